"""Scenes: the document, its plan, and its simulation."""

from .builtin_scenes import builtin_names
from .document_parts import AngularVelocity, Attitude, Body, Epoch, Times, Tolerance
from .scene import Scene

__all__ = ["AngularVelocity", "Attitude", "Body", "Epoch", "Scene", "Times", "Tolerance", "builtin_names"]
