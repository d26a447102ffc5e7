"""A reader never accepts what its own writer would refuse: damaged files are refused, or written again."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from attitude import Ephemeris, FormatError, InputError
from attitude.formats.registry import FORMATS
from attitude.times.instants import Instants
from tests.formats.damage import EDITS, check_same, edited, motion, originals, outcome, read, written
from tests.formats.texts import aem, stk

each_format = pytest.mark.parametrize("format", FORMATS)
# ECSV is fifty times slower to read than the others; tests/benchmarks/fuzz_formats.py has campaigns.
EXAMPLES = dict.fromkeys(FORMATS, 150) | {"ecsv": 25, "fits": 150, "parquet": 60, "czml": 80, "ck": 60}


@each_format
def test_whole_files_are_read_and_written_again(format):
    assert [outcome(format, content) for content in originals(format)] == ["kept"] * len(originals(format))


@pytest.mark.filterwarnings("ignore:ERFA function:erfa.ErfaWarning")
@each_format
def test_damaged_files_are_refused_or_written_again(format):
    seen = set()

    @settings(max_examples=EXAMPLES[format], deadline=None, database=None, derandomize=True)
    @given(st.sampled_from(originals(format)), EDITS)
    def damage(content, edits):
        seen.add(outcome(format, edited(content, edits)))

    damage()
    assert seen == {"refused", "kept"}


# -- files that readers took and writers refused ---------------------------------------------------

AEM = {"TIME_SYSTEM": "TAI", "REF_FRAME_A": "GCRF", "STOP_TIME": "2020-01-02T00:00:00"}
APART = "attitudes.1.: epochs at least 2e-09 s apart"
REFUSED = [
    (
        "aem",
        "QUATERNION",
        "2020-01-01T00:00:00.0000000001 0 0 0 1\n2020-01-01T00:00:00.0000000004 0 0 0 1",
        APART,
    ),
    ("aem", "QUATERNION", "2020-01-01T23:59:59.9999999999 0 0 0 1\n2020-01-02T00:00:00 0 0 0 1", APART),
    (
        "aem",
        "QUATERNION/DERIVATIVE",
        "2020-01-01T00:00:00 0 0 0 1 1e307 0 0 0",
        r"line 15: a rate of more than 1e\+306 rad/s",
    ),
    ("stk", "1 Jul 2007 12:00:00.5", "0 0 0 0 1\n1e-17 0 0 0 1", r"line 7: 0.[45]\d* s is not after 0.[45]"),
    ("stk", "1 Jul 2007 12:00:00", "1e12 0 0 0 1", "line 6: STK has years of four digits, not 33696"),
    ("stk", "1 Jul 2007 12:00:00", "0 0 0 0 1\n1e300 0 0 0 1", "instants that a calendar has"),
    ("ecsv", "0.2999999999999999", "null", "line 47: elapsed, quaternion or rate without a value"),
    ("csv", ",2.0,", ",1e300,", "instants that a calendar has .1e.300 s from the epoch"),
    ("json", "2457754.0", "-1e9", "epoch beyond any calendar|a calendar has"),
]


@pytest.mark.parametrize(("format", "first", "second", "words"), REFUSED, ids=range(len(REFUSED)))
def test_what_its_writer_would_refuse_is_refused(format, first, second, words):
    """Type and rows of an AEM, epoch and rows of an STK file; else a number and another for it."""
    if format == "aem":
        text = aem(second, ATTITUDE_TYPE=first, **AEM)
    elif format == "stk":
        text = stk(second, first)
    else:
        text = originals(format)[0].decode().replace(first, second, 1)
    with pytest.raises(FormatError, match=words):
        read(format, text.encode())


def with_rate(rate):
    whole = motion().at(np.arange(3.0))
    return Ephemeris(np.array(whole.quaternion("wxyz")), whole.instants, "ICRF", None, np.full((3, 3), rate))


@pytest.mark.parametrize("format", ["aem", "aem-xml", "stk"])
def test_rate_that_is_no_number_in_degrees_is_not_written(format):
    with pytest.raises(FormatError, match="a rate that overflows a double in deg/s"):
        written(format, with_rate(1e307))
    check_same(format, with_rate(1e305), read(format, written(format, with_rate(1e305))))


@each_format
def test_name_with_half_of_a_character_is_not_written(format):
    ephemeris = motion().at([0.0, 1.0])
    ephemeris = replace(ephemeris, name="a\ud800")
    with pytest.raises(FormatError, match="unpaired surrogate"):
        written(format, ephemeris)


@each_format
def test_ephemeris_of_no_instants_is_not_written(format):
    empty = Ephemeris(np.empty((0, 4)), Instants(np.empty(0), None, None), "GCRF")
    with pytest.raises((FormatError, InputError), match="no instants"):
        written(format, empty)
