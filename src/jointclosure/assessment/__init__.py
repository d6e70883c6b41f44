"""Assessment of a scene: price of accuracy, hardness, and the choice of its effects."""
