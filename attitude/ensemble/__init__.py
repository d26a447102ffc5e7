"""Ensembles: attitudes of many bodies, drawn about a scene's or read from a table; statistics and stores.

The path of the data: states at the epoch -> motion of a block of bodies -> sums for statistics, or a store.
"""

from .ensemble import Ensemble

__all__ = ["Ensemble"]
