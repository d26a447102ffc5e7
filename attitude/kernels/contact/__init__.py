"""Kernels of flight and contact with a plane."""
