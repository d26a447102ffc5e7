"""Fixtures that tests of several topics share."""

import pytest


@pytest.fixture
def offline():
    """astropy asks for no network, and takes predictions however old its tables are."""
    from astropy.utils import iers

    with iers.conf.set_temp("auto_download", False), iers.conf.set_temp("auto_max_age", None):
        yield


@pytest.fixture(scope="session")
def java():
    """JClass of a machine that knows Orekit; skips where there is none."""
    from attitude.cost import AbsentError
    from attitude.cost.methods import orekit

    try:
        orekit.start()
    except AbsentError as error:
        pytest.skip(str(error))
    return pytest.importorskip("jpype").JClass
