"""Rough walls: JRC relations, synthesis, and what a wall has."""
