"""An ellipse, exactly, and files of it in the formats of orbits."""

import numpy as np
from astropy.time import Time

MU = 3.986004418e14
A, E, TILT = 7.1e6, 0.02, np.deg2rad(63.0)
EPOCH = Time("2026-01-01T00:00:00", scale="utc")


def state(t):
    """(n, 3) m and (n, 3) m/s of the ellipse at seconds t, by Newton's iteration of Kepler's equation."""
    n = np.sqrt(MU / A**3)
    mean = n * np.asarray(t, dtype=float)
    angle = mean.copy()
    for _ in range(30):
        angle -= (angle - E * np.sin(angle) - mean) / (1.0 - E * np.cos(angle))
    b, rate = np.sqrt(1.0 - E * E), n / (1.0 - E * np.cos(angle))
    x, y = A * (np.cos(angle) - E), A * b * np.sin(angle)
    vx, vy = -A * np.sin(angle) * rate, A * b * np.cos(angle) * rate
    c, s = np.cos(TILT), np.sin(TILT)
    return np.stack([x, c * y, s * y], axis=1), np.stack([vx, c * vy, s * vy], axis=1)


def dates(t, scale="utc"):
    """ISO 8601 dates of seconds since EPOCH."""
    from astropy import units as u

    times = getattr(EPOCH + np.asarray(t) * u.s, scale)
    times.precision = 9
    return times.isot.tolist()


def numbers(*vectors):
    return " ".join(repr(float(value)) for vector in vectors for value in vector)


def oem_rows(t, scale="utc", velocities=True):
    r, v = state(t)
    return [f"{date} {numbers(a / 1e3, b / 1e3)}" for date, a, b in zip(dates(t, scale), r, v, strict=True)]


def oem_segment(t, scale="utc", **metadata):
    rows = oem_rows(t, scale)
    fields = {
        "OBJECT_NAME": "SAT",
        "OBJECT_ID": "2026-001A",
        "CENTER_NAME": "EARTH",
        "REF_FRAME": "EME2000",
        "TIME_SYSTEM": scale.upper(),
        "START_TIME": rows[0].split()[0],
        "STOP_TIME": rows[-1].split()[0],
        "INTERPOLATION": "HERMITE",
        "INTERPOLATION_DEGREE": "7",
    } | metadata
    meta = "\n".join(f"{name} = {value}" for name, value in fields.items() if value is not None)
    return f"META_START\n{meta}\nMETA_STOP\n" + "\n".join(rows) + "\n"


def oem(*segments):
    head = "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2026-01-01T00:00:00\nORIGINATOR = ME\n"
    return head + "".join(segments)


def oem_xml(t):
    """The same in XML, of one segment."""
    kvn = oem_segment(t)
    meta, _, rows = kvn.partition("META_STOP\n")
    fields = [line.split(" = ") for line in meta.splitlines()[1:]]
    elements = "".join(f"<{name}>{value}</{name}>\n" for name, value in fields)
    names = ("EPOCH", "X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT")
    states = "".join(
        "<stateVector>"
        + "".join(f"<{name}>{word}</{name}>" for name, word in zip(names, row.split(), strict=True))
        + "</stateVector>\n"
        for row in rows.splitlines()
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<oem id="CCSDS_OEM_VERS" version="2.0">\n<header>'
        "<CREATION_DATE>2026-01-01T00:00:00</CREATION_DATE><ORIGINATOR>ME</ORIGINATOR></header>\n<body>"
        f"<segment><metadata>{elements}</metadata><data><COMMENT>rows</COMMENT>{states}</data></segment>"
        "</body></oem>\n"
    )


def stk(t, block="EphemerisTimePosVel", method="Hermite", order=7, unit="Kilometers", **keywords):
    r, v = state(t)
    scale = 1e3 if unit == "Kilometers" else 1.0
    parts = [(a, b) if block.endswith("Vel") else (a,) for a, b in zip(r / scale, v / scale, strict=True)]
    rows = "\n".join(f"{float(s)!r} {numbers(*part)}" for s, part in zip(t, parts, strict=True))
    fields = {
        "NumberOfEphemerisPoints": len(r),
        "ScenarioEpoch": "1 Jan 2026 00:00:00.000",
        "InterpolationMethod": method,
        "InterpolationOrder": order,
        "CentralBody": "Earth",
        "CoordinateSystem": "J2000",
        "DistanceUnit": unit,
    } | keywords
    head = "\n".join(f"{name} {value}" for name, value in fields.items() if value is not None)
    return f"stk.v.11.0\n# a comment\nBEGIN Ephemeris\n{head}\n\n{block}\n\n{rows}\n\nEND Ephemeris\n"


def csv(t, unit="km"):
    r, v = state(t)
    scale = 1e3 if unit == "km" else 1.0
    names = [f"{name}_{unit}" for name in "xyz"] + [f"v{name}_{unit}_s" for name in "xyz"]
    rows = [
        f"{date}," + numbers(a / scale, b / scale).replace(" ", ",")
        for date, a, b in zip(dates(t), r, v, strict=True)
    ]
    return "\n".join(["time," + ",".join(names), *rows]) + "\n"
