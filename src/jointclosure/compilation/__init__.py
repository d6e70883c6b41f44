"""Kernels compiled and cached, and digests of the code that results depend on."""
