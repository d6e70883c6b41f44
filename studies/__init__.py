"""Studies of joints: each folder has its joints, tables, figures, page and test."""
