"""Compilation and cache of kernels, and digests of the code that results depend on."""
