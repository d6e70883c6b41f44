"""The scale effect: patch length, grid spacing, and scalings by which results carry over."""
