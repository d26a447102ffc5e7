"""Rotations, inertial frames, and frames that rotate with the Earth."""
