"""Words in the table of checks. They are not in `checks.py`, whose imports take long."""

REPORTED = "reported only"
"""Entry of the column ``required`` for a number without a limit."""
