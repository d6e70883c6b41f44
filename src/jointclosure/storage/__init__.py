"""The only place that reads and writes files of results; a module for each kind.

They are apart so that a rule's code digest has only the kinds that the rule needs. Files
of scanned walls, which others wrote, are read by `jointclosure.scans`.
"""
