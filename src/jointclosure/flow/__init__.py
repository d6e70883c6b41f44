"""Flow through a joint: Reynolds' equation on its aperture at every step of a history."""
