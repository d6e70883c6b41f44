"""Reading and writing of result files: a module a kind, so that code digests name what is used."""
