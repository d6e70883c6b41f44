"""The configuration of a study: merged, checked, and turned into SI."""
