"""Tests of the 50-digit oracle, and the published closed form in mpmath."""
