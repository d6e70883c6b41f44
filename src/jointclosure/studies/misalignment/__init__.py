"""Walls that are tilted against each other, or rotated about the normal."""
