"""Curves of a laboratory held against a study."""
