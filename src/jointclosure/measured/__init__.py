"""Measured closure curves of laboratories: comparison with a study, and fit of a joint."""
