"""Word in the table of checks; it is not in `checks`, whose imports take long."""

REPORTED = "reported only"
"""Entry of the column ``required`` for a number without a limit."""
