"""Tests of the compared methods and of the near-singular cases."""
