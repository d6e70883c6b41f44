"""Selection of the effects that a case needs."""
