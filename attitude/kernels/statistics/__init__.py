"""Kernels of ensembles: random states and sums over bodies."""
