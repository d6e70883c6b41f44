"""Sensitivity to rock properties: responses, indifference intervals, claims."""
