"""Assessment of a study's rocks: accuracy and its cost, hardness, and effects that are needed."""
