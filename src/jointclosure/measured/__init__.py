"""Measured closure curves of laboratories: reading, fit of a joint, and validation of the model."""
