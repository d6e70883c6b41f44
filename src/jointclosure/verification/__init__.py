"""The code judged: an oracle that shares nothing with the solvers, and cases that are hard."""
