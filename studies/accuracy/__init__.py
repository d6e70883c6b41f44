"""Cost of accuracy: the same surfaces closed at many settings of the numerics."""
