"""Kernels of the solvers for motion under torques."""
