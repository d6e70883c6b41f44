"""The engine: quantities of a closed joint; joints closed alone, as ensembles and as points."""
