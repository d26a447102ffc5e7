"""Inertia, principal axes, and the constants of the torque-free motion of one body or of many."""
