"""Verification: hard cases, exact arithmetic, and judges that share no code with the solvers."""
