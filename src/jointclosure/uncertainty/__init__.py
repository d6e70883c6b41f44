"""The range of the results of one joint: what is not known of it, and its numerical error."""
