"""Uncertainty of the results of one joint: sources, simulated variants, ranges, numerical error."""
