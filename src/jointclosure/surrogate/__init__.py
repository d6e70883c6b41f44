"""Bearing-area law for the closure of a first loading, and its errors."""
