"""One joint through its load cycles: protocol, steps, history, fields and flow."""
