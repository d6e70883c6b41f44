"""Work shared among processes: workers, progress, and a cache of what they made."""
