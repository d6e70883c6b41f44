"""Solvers for equilibrium and breakage at one closure: `fast`, and `reference` as in the paper."""
