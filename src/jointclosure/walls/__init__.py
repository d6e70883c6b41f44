"""Rough walls: JRC relations, synthesis, and measures of walls."""
