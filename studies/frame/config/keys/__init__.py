"""Keys of a configuration's file, a module a section: types, bounds, units and descriptions."""
