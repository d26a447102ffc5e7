"""Windows: the intervals of a motion in which a condition holds, such as an axis near the Sun."""

from .condition import Condition, above_plane, angle, in_shadow, parse_condition
from .window_table import Windows

__all__ = ["Condition", "Windows", "above_plane", "angle", "in_shadow", "parse_condition"]
