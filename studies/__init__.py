"""Studies of joints: each folder has what it closes, its tables, figures, page and test."""
