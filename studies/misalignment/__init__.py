"""Walls that are tilted, or rotated about the normal of the joint."""
