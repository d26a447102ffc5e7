"""Small files of attitudes, by hand."""

HEADER = "CCSDS_AEM_VERS = {}\nCREATION_DATE = 2020-01-01T00:00:00\nORIGINATOR = NASA\n"
METADATA = {
    "OBJECT_NAME": "SAT",
    "OBJECT_ID": "2000-052A",
    "REF_FRAME_A": "J2000",
    "REF_FRAME_B": "SC_BODY_1",
    "TIME_SYSTEM": "UTC",
    "START_TIME": "2020-01-01T00:00:00",
    "STOP_TIME": "2020-01-01T00:01:00",
    "ATTITUDE_TYPE": "QUATERNION",
}


def aem_segment(rows, **metadata):
    """One segment, the keywords of its metadata in this order; None takes a keyword away."""
    fields = METADATA | metadata
    meta = "\n".join(f"{name} = {value}" for name, value in fields.items() if value is not None)
    return f"META_START\n{meta}\nMETA_STOP\nDATA_START\n{rows}\nDATA_STOP\n"


def aem(rows, version="2.0", header="", **metadata):
    """A CCSDS AEM in KVN of one segment: META_START is in line 4, the first row in line 15."""
    return HEADER.format(version) + header + aem_segment(rows, **metadata)


def stk(rows, epoch="1 Jan 2024 00:00:00"):
    """An STK attitude file: the first row is in line 6."""
    head = f"stk.v.11.0\nBEGIN Attitude\nScenarioEpoch {epoch}\nCoordinateAxes ICRF\n"
    return f"{head}AttitudeTimeQuaternions\n{rows}\nEND Attitude\n"


SCLK = """KPL/SCLK
\\begindata
SCLK_KERNEL_ID = ( @2004-01-01 )
SCLK_DATA_TYPE_{id} = ( 1 )
SCLK01_TIME_SYSTEM_{id} = ( {system} )
SCLK01_N_FIELDS_{id} = ( 2 )
SCLK01_MODULI_{id} = ( 4294967296 256 )
SCLK01_OFFSETS_{id} = ( 0 0 )
SCLK01_OUTPUT_DELIM_{id} = ( 1 )
SCLK_PARTITION_START_{id} = ( {starts} )
SCLK_PARTITION_END_{id} = ( {ends} )
SCLK01_COEFFICIENTS_{id} = ( {rows} )
\\begintext
"""


def clock_kernel(number, rows, system, starts, ends):
    """SPICE's kernel of a clock of 256 ticks a second."""
    return SCLK.format(id=number, rows=rows, system=system, starts=starts, ends=ends)
