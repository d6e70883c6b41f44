"""Physics of one pair of asperities: scalar kernels, one equation each."""
