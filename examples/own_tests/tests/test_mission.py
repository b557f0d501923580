"""What a team asks of its drone before a release: take-off, mission, landing.

Nothing here knows of faults: `scaloft-fi suite` has the flights fly them.
"""

import pytest

import scaloft_fi


@pytest.fixture(scope="module")
def flight():
    return scaloft_fi.open().fly("baseline", "T0O0W0D0H0", seed=0)


def test_takeoff(flight):
    height_m, elapsed_s = flight.log["z_m"], flight.log["elapsed_s"]
    assert max(height_m[elapsed_s < 8.0]) > 1.4


def test_mission(flight):
    assert "OP1" not in flight.violated


def test_landing(flight):
    assert flight.ending == "landed"
    assert abs(flight.log["x_m"][-1]) < 0.5
    assert abs(flight.log["y_m"][-1]) < 0.5


def test_nothing_is_struck(flight):
    assert flight.struck == ""
