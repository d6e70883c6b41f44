"""Which reading of what the paper leaves open gives the paper's Table 3."""
