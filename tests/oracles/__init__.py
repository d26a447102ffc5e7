"""Attitude and rate of torque-free bodies to fifty digits, by routes independent of the library."""
