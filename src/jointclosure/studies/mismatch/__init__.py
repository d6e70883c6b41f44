"""Mated, natural and non-mated walls: closure against mismatch wavelength and shift."""
