"""Attitude parameter messages, by hand; the spinner is that of Orekit's example of a full message."""

HEAD = """CCSDS_APM_VERS = 2.0
CREATION_DATE = 2023-02-05T12:00:00
ORIGINATOR = ME
COMMENT a spinner
OBJECT_NAME = SPINNER
OBJECT_ID = 2015-011A
CENTER_NAME = EARTH
TIME_SYSTEM = {system}
EPOCH = 2023-01-01T00:00:00.0000
"""


def head(system="TAI"):
    return HEAD.format(system=system)


def block(name, a="EME2000", b="SC_BODY_1", **values):
    frames = f"REF_FRAME_A = {a}\nREF_FRAME_B = {b}\n" if name not in ("INERTIA", "MAN") else ""
    lines = "".join(f"{key} = {value}\n" for key, value in values.items())
    return f"{name}_START\n{frames}{lines}{name}_STOP\n"


EULER = block("EULER", EULER_ROT_SEQ="ZXZ", ANGLE_1="10 [deg]", ANGLE_2="20 [deg]", ANGLE_3="0 [deg]")
SPIN = block(
    "SPIN",
    SPIN_ALPHA="-80 [deg]",
    SPIN_DELTA="70 [deg]",
    SPIN_ANGLE="0 [deg]",
    SPIN_ANGLE_VEL="1 [deg/s]",
    NUTATION="0.1 [deg]",
    NUTATION_PER="720 [s]",
    NUTATION_PHASE="-85 [deg]",
)
INERTIA = block(
    "INERTIA",
    INERTIA_REF_FRAME="SC_BODY_1",
    IXX="1443.1 [kg*m**2]",
    IYY="1445.2 [kg*m**2]",
    IZZ="1760.2 [kg*m**2]",
    IXY="-86.4 [kg*m**2]",
    IXZ="0.0 [kg*m**2]",
    IYZ="-0.09 [kg*m**2]",
)


def manoeuvre(
    start="2023-01-01T01:00:00.0000", duration="1 [s]", frame="SC_BODY_1", torque=(1, 0, 0), **more
):
    components = {f"MAN_TOR_{axis}": value for axis, value in zip("XYZ", torque, strict=True)}
    return block(
        "MAN", MAN_EPOCH_START=start, MAN_DURATION=duration, MAN_REF_FRAME=frame, **components, **more
    )


SPINNER = head() + EULER + SPIN + INERTIA + manoeuvre(MAN_DELTA_MASS="0.001 [kg]")
QUAT = block("QUAT", Q1=0.171010, Q2=-0.030154, Q3=0.336824, QC=0.925417)
ANGVEL = block("ANGVEL", ANGVEL_FRAME="SC_BODY_1", ANGVEL_X="0.1 [deg/s]", ANGVEL_Y=0.05, ANGVEL_Z=-0.3)

FIRST_VERSION = """CCSDS_APM_VERS = 1.0
CREATION_DATE = 2004-02-14T19:23:57
ORIGINATOR = JPL
OBJECT_NAME = ROVER
OBJECT_ID = 2004-003A
CENTER_NAME = EARTH
TIME_SYSTEM = UTC
EPOCH = 2004-02-14T14:28:15.1172
Q_FRAME_A = SC_BODY_1
Q_FRAME_B = EME2000
Q_DIR = A2B
Q1 = 0.03123
Q2 = 0.78543
Q3 = 0.39158
QC = 0.47832
EULER_FRAME_A = EME2000
EULER_FRAME_B = SC_BODY_1
EULER_DIR = A2B
EULER_ROT_SEQ = 312
RATE_FRAME = EULER_FRAME_A
Z_ANGLE = -31.4988
X_ANGLE = 35.8200
Y_ANGLE = -106.9024
Z_RATE = 0.02156
X_RATE = 0.1045
Y_RATE = 0.03214
I11 = 6080.0
I22 = 5245.5
I33 = 8067.3
I12 = -135.9
I13 = 89.3
I23 = -90.7
MAN_EPOCH_START = 2004-02-14T14:29:00.5098
MAN_DURATION = 3
MAN_REF_FRAME = SC_BODY_1
MAN_TOR_1 = -1.25
MAN_TOR_2 = -0.5
MAN_TOR_3 = 0.5
MAN_EPOCH_START = 2004-02-14T14:30:00.0
MAN_DURATION = 3
MAN_REF_FRAME = SC_BODY_1
MAN_TOR_1 = 1.25
MAN_TOR_2 = 0.5
MAN_TOR_3 = -0.5
"""
