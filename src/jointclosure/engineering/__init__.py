"""A closed joint in the words of engineers: curves, stiffness, laws and other programs' inputs."""
