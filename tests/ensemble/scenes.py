"""Scenes to draw bodies about."""

from attitude import Scene


def scene(**changes):
    document = {
        "name": "a generic body",
        "body": {"moments": [1.0, 1.6, 2.1], "unit": "kg m2"},
        "epoch": {"time": "2020-01-01T00:00:00", "scale": "utc"},
        "frame": "GCRF",
        "attitude": {"quaternion": [0.1, -0.7, 0.5, 0.5], "order": "wxyz"},
        "angular_velocity": {"value": [0.3, -0.5, 0.9], "unit": "rad/s"},
        "times": {"start": 0, "stop": 10, "count": 5, "unit": "s"},
    }
    return Scene.model_validate(document | changes)


TENSOR = {
    "tensor": [[17023.3, 397.1, -2171.4], [397.1, 124825.7, 344.2], [-2171.4, 344.2, 129112.2]],
    "unit": "kg m2",
}
PLATE = {"moments": [1.0, 1.0, 2.0], "unit": "kg m2"}
SPREADS = {"moments": "2 %", "angular_velocity": "0.1 deg/s", "attitude": "1 deg"}
