"""What accuracy costs: designs, errors, times, and the table of presets."""
