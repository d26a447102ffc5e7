"""Scenes: the document, its plan, and its simulation."""

from .document import Scene, builtin_names
from .document_parts import AngularVelocity, Attitude, Body, Epoch, Times, Tolerance

__all__ = ["AngularVelocity", "Attitude", "Body", "Epoch", "Scene", "Times", "Tolerance", "builtin_names"]
