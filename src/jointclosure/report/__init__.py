"""A study as one page to read: frames and datasets in, HTML that needs nothing else out."""
