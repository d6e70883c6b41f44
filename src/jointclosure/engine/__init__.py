"""The engine: quantities of a closed joint, and joints closed alone or as ensembles."""
