"""Word of the table of checks, apart from the checks, whose libraries take long to load."""

REPORTED = "reported only"
"""What is required of a number for which there is no limit."""
