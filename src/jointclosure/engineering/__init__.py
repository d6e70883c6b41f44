"""Engineering results of a closed joint: curves, stiffness, laws, and input of other programs."""
