"""Tables and numbers that pages show of stored results, one module for each page."""
