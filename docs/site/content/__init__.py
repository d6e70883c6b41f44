"""What pages show of stored results: a module for a page, with its tables and numbers."""
