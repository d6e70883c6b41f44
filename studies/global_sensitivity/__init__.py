"""Variance indices of properties and of open choices that vary together."""
