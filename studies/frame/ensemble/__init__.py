"""Engine of studies: surfaces of all cases are made, closed, joined, checked and compared."""
