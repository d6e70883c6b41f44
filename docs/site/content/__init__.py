"""What pages show of stored results: a module for each page, with a function for each table."""
