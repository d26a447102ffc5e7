"""Scenes: the document, its plan, and its simulation."""

from .document import AngularVelocity, Attitude, Body, Epoch, Scene, Times, Tolerance, builtin_names

__all__ = ["AngularVelocity", "Attitude", "Body", "Epoch", "Scene", "Times", "Tolerance", "builtin_names"]
