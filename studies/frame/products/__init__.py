"""Products of a study: what they need, the function that makes them, their files."""
