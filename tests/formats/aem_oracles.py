"""What other readers of AEM make of a text: seconds from the first epoch, quaternions, rates."""

from datetime import date

import numpy as np
import pytest

from attitude.cost.method import AbsentError
from attitude.cost.methods import orekit

# TAI - UTC on the days from which it held, as far as the tests go.
LEAP_SECONDS = {date(1999, 1, 1): 32, date(2006, 1, 1): 33, date(2009, 1, 1): 34, date(2012, 7, 1): 35}
LEAP_SECONDS |= {date(2015, 7, 1): 36, date(2017, 1, 1): 37}


def brahe_message(text):
    return pytest.importorskip("brahe.ccsds").AEM.from_str(text)


def brahe(text):
    """Of all segments in a row, as (seconds, wxyz, rad/s or None)."""
    time_system = pytest.importorskip("brahe").TimeSystem.TAI
    states = [state for segment in brahe_message(text).segments for state in segment.states]
    seconds = [state.epoch.seconds_past_j2000_as_time_system(time_system) for state in states]
    quaternions = [state.quaternion.to_vector(True) for state in states]
    rates = [state.angular_velocity for state in states]
    return _arrays(seconds, quaternions, None if rates[0] is None else rates)


def ccsds_message(text):
    return pytest.importorskip("ccsds_ndm").Aem.from_str(text)


def ccsds_ndm(text):
    """Its epochs are the texts themselves."""
    data = [segment.data for segment in ccsds_message(text).segments]
    numbers = np.concatenate([part.attitude_states_numpy for part in data])
    rates = np.deg2rad(numbers[:, 4:]) if numbers.shape[1] == 7 else None
    return None, numbers[:, [3, 0, 1, 2]], rates


def orekit_reader(text):
    """Of Orekit, with the leap seconds above and no other data."""
    java, source = _orekit(), text.encode()
    content = java("java.io.ByteArrayInputStream")
    opener = _proxy("org.orekit.data.DataSource$StreamOpener", openOnce=lambda: content(_bytes(source)))
    parser = java("org.orekit.files.ccsds.ndm.ParserBuilder")().buildAemParser()
    message = parser.parseMessage(java("org.orekit.data.DataSource")("text.aem", opener))
    states = [state for part in message.getSegments() for state in part.getData().getAngularCoordinates()]
    seconds = [state.getDate().durationFrom(states[0].getDate()) for state in states]
    turns = [state.getRotation() for state in states]
    quaternions = [[turn.getQ0(), turn.getQ1(), turn.getQ2(), turn.getQ3()] for turn in turns]
    rates = [list(state.getRotationRate().toArray()) for state in states]
    return _arrays(seconds, quaternions, rates if np.any(rates) else None)


def _arrays(seconds, quaternions, rates):
    seconds = np.array(seconds)
    return seconds - seconds[0], np.array(quaternions), None if rates is None else np.array(rates)


def _orekit():
    try:
        orekit.start()
    except AbsentError as absent:
        pytest.skip(str(absent))
    java = pytest.importorskip("jpype").JClass
    scales = java("org.orekit.data.DataContext").getDefault().getTimeScales()
    loader = _proxy("org.orekit.time.UTCTAIOffsetsLoader", loadOffsets=lambda: _offsets(java))
    scales.addUTCTAIOffsetsLoader(loader)
    return java


def _offsets(java):
    offsets = java("java.util.ArrayList")()
    for day, offset in LEAP_SECONDS.items():
        start = java("org.orekit.time.DateComponents")(day.year, day.month, day.day)
        offsets.add(java("org.orekit.time.OffsetModel")(start, offset))
    return offsets


def _proxy(name, **functions):
    return pytest.importorskip("jpype").JProxy(name, dict=functions)


def _bytes(content):
    jpype = pytest.importorskip("jpype")
    return jpype.JArray(jpype.JByte)(content)


READERS = {"brahe": brahe, "ccsds-ndm-py": ccsds_ndm, "Orekit": orekit_reader}
WRITERS = {
    "brahe": lambda text, syntax: brahe_message(text).to_string(syntax.upper()),
    "ccsds-ndm-py": lambda text, syntax: ccsds_message(text).to_str(syntax),
}


def orekit_positions(text, seconds, rows):
    """(n, 3) m by Orekit's reader of OEM and its Hermite interpolation, at seconds since the first row."""
    java, source = _orekit(), text.replace("EARTH", "ITS CENTRE").encode()  # of bodies it needs data
    content = java("java.io.ByteArrayInputStream")
    opener = _proxy("org.orekit.data.DataSource$StreamOpener", openOnce=lambda: content(_bytes(source)))
    parser = java("org.orekit.files.ccsds.ndm.ParserBuilder")().withMu(3.986004418e14).buildOemParser()
    message = parser.parseMessage(java("org.orekit.data.DataSource")("text.oem", opener))
    states = list(message.getSegments().get(0).getCoordinates())
    both = java("org.orekit.utils.CartesianDerivativesFilter").USE_PV
    interpolate = java("org.orekit.utils.TimeStampedPVCoordinatesHermiteInterpolator")(rows, both).interpolate
    samples, start = java("java.util.Arrays").asList(states), states[0].getDate()
    return np.array(
        [list(interpolate(start.shiftedBy(float(t)), samples).getPosition().toArray()) for t in seconds]
    )


def orekit_apm(text):
    """(wxyz, deg/s, tensor, torque, duration) of an APM by Orekit."""
    java, source = _orekit(), text.encode()
    content = java("java.io.ByteArrayInputStream")
    opener = _proxy("org.orekit.data.DataSource$StreamOpener", openOnce=lambda: content(_bytes(source)))
    parser = java("org.orekit.files.ccsds.ndm.ParserBuilder")().buildApmParser()
    message = parser.parseMessage(java("org.orekit.data.DataSource")("text.apm", opener))
    data = message.getSegments().get(0).getData()
    turn, first = data.getQuaternionBlock().getQuaternion(), data.getManeuvers().get(0)
    rate = data.getAngularVelocityBlock()
    tensor = data.getInertiaBlock().getInertiaMatrix()
    return (
        np.array([turn.getQ0(), turn.getQ1(), turn.getQ2(), turn.getQ3()]),
        np.rad2deg([rate.getAngVelX(), rate.getAngVelY(), rate.getAngVelZ()]),
        np.array([[tensor.getEntry(i, j) for j in range(3)] for i in range(3)]),
        np.array(list(first.getTorque().toArray())),
        float(first.getDuration()),
    )


def orekit_acm(text):
    """(seconds since T0, rows Q1 Q2 Q3 QC and deg/s, tensor, variances in deg2) of an ACM by Orekit."""
    java, source = _orekit(), text.encode()
    content = java("java.io.ByteArrayInputStream")
    opener = _proxy("org.orekit.data.DataSource$StreamOpener", openOnce=lambda: content(_bytes(source)))
    parser = java("org.orekit.files.ccsds.ndm.ParserBuilder")().buildAcmParser()
    message = parser.parseMessage(java("org.orekit.data.DataSource")("text.acm", opener))
    segment = message.getSegments().get(0)
    data, zero = segment.getData(), segment.getMetadata().getEpochT0()
    states = [state for block in data.getAttitudeBlocks() for state in block.getAttitudeStates()]
    rows = [list(state.getElements()) for state in states]
    tensor = data.getPhysicBlock().getInertiaMatrix()
    covariances = [
        each.getMatrix() for block in data.getCovarianceBlocks() for each in block.getCovariances()
    ]
    return (
        np.array([state.getDate().durationFrom(zero) for state in states]),
        np.concatenate([np.array(rows)[:, :4], np.rad2deg(np.array(rows)[:, 4:])], axis=1),
        np.array([[tensor.getEntry(i, j) for j in range(3)] for i in range(3)]),
        np.array([[each.getEntry(i, i) for i in range(6)] for each in covariances]) * (180.0 / np.pi) ** 2,
    )
