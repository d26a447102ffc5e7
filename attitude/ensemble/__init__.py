"""Many bodies: drawn about a scene or read from a table, moved, and told as statistics or stored.

The path of the data: states -> motion of a block of bodies -> gathered, or stored.
"""

from .ensemble import Ensemble

__all__ = ["Ensemble"]
