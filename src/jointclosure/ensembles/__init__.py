"""Many joints of one rock and load: simulation, and the quantities that are read of each joint."""
