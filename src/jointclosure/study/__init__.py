"""A study: cases from a configuration, their ensembles, and what they claim."""
