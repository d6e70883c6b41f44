"""Questions that are asked of ensembles; no study imports another."""
