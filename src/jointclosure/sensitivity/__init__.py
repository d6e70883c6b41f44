"""Which rock properties matter: responses, indifference intervals, claims."""
