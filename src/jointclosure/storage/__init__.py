"""Reading and writing of result files, one module for each kind of file.

The modules are separate so that the code digest of a rule contains only the kinds that the rule
needs. Files of scanned walls are read by `jointclosure.walls.scans`.
"""
