"""Verification: hard cases, judged by an oracle that shares no code with the solvers."""
