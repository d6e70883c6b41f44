"""Cases of a study: their surfaces made, closed, put together, checked and compared."""
