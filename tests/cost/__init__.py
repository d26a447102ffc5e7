"""Tests of the methods compared and of the hard ladders."""
