"""Ensembles of joints of one rock and load: simulation, and the quantities read of each joint."""
