"""Exposure control and pose buffer; whole companions fly in tests/sim."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.stack.messages import Metering
from scaloft_fi.stack.reference.companion import ExposureControl, PoseBuffer
from tests.stack.conftest import pose_at


def test_the_exposure_loop_removes_the_metered_error_up_to_its_limit_where_the_gain_rises(config):
    control, dark = ExposureControl(config.exposure), ExposureControl(config.exposure)
    for _ in range(100):
        order = control.meter(Metering(0.0, 1.3 - control.meter(None).ev))
        most = dark.meter(Metering(0.0, 7.0))
    assert (order.ev, order.gain) == (pytest.approx(1.3, abs=1e-3), 1.0)
    assert (most.ev, most.gain) == (4.0, 4.0)


@given(st.floats(0.0, 2.6))
def test_a_pose_lies_between_two_ticks_or_a_little_beyond_the_newest(stamp_s):
    buffer = PoseBuffer(span_s=1.0, reach_s=0.5)
    assert buffer.at(stamp_s) is None
    for k in range(41):
        buffer.add(pose_at(x=k * 0.05, yaw=0.1 * min(k, 20), stamp_s=k * 0.05, velocity=(1.0, 0.0, 0.0)))
    buffer.add(pose_at(x=7.0, stamp_s=0.5))  # no newer than the newest, and dropped
    found, oldest_s = buffer.at(stamp_s), 1.0
    if not oldest_s - 1e-9 <= stamp_s <= 2.5:
        assert found is None
    elif oldest_s < stamp_s:
        assert found.position[0] == pytest.approx(stamp_s, abs=1e-9)
        assert found.yaw_rad == pytest.approx(2.0, abs=1e-9)
        assert np.linalg.norm(found.attitude) == pytest.approx(1.0)
