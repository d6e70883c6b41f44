"""Jobs of the workflow: their log, their progress, and the seals on what they read and write."""
