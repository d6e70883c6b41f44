"""Mated, natural and non-mated walls: effects of mismatch and shift."""
