"""Tables of a simulated joint, and inputs of UDEC, 3DEC, PorePy, GEOS and of programs with meshes.

Functions return contents of files by their names, with remarks (`Exported`). docs/export.md
describes the files.
"""
