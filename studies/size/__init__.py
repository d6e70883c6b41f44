"""Scale effect: nested patches of the same walls, at many sizes and spacings."""
