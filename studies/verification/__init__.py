"""Verification: hard cases, exact arithmetic, and oracles that share no code with the solvers."""
