"""A sensor of another author's package: one class and one declaration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.marks import NotNegative
from scaloft_fi.sim.flight import FlightLoop, physics_server
from scaloft_fi.sim.load import load
from scaloft_fi.sim.sensors.sensor import SENSORS, SensorKind
from scaloft_fi.stack.declaration import PlainWire
from scaloft_fi.streams import Table


class Range(NamedTuple):
    stamp_s: float
    range_m: float


@dataclass(frozen=True)
class RangeConfig:
    sigma_m: NotNegative


class RangeFinder:
    def __init__(self, config, flight):
        self.sigma_m = config.sigma_m
        self.noise = Table(1, *flight.stream, "range")

    def measure(self, moment):
        noise_m = self.sigma_m * float(self.noise.row(moment.tick)[0])
        return Range(moment.now_s, float(moment.view.depth[24, 32]) + noise_m)


@pytest.fixture
def declared(monkeypatch):
    kind = SensorKind(RangeFinder, Range, RangeConfig, period_ticks=2, latency_s=0.1)
    monkeypatch.setitem(SENSORS._entries, "range", kind)


def with_entry(study, text):
    with (study / "sensors.yaml").open("a") as file:
        file.write(text)
    return study


def flown(config, ticks=12):
    """Digest of so many ticks, and what the stack got at each."""
    frames = []
    with physics_server() as client:
        flight = FlightLoop(client, config, config.scenario(config.grid.situation("T0O0W0D0H0")), 0, PlainWire())
        companion = flight.stack.companion
        flight.stack.companion = lambda now_s, frame: frames.append(frame) or companion(now_s, frame)
        for _ in range(ticks):
            flight.tick()
            flight.advance()
        return flight.log().digest, frames


@pytest.mark.flight
def test_a_declared_sensor_flies_where_the_study_has_an_entry_for_it_and_moves_no_other(declared, study, config):
    digest, frames = flown(load(with_entry(study, "range:\n  sigma_m: 0.02\n")))
    assert [k for k, frame in enumerate(frames) if frame["range"] is not None] == [2, 4, 6, 8, 10]
    assert frames[6]["range"].stamp_s == pytest.approx(0.2)
    without, plain = flown(config)
    assert digest == without
    assert "range" not in plain[0].by_sensor
    assert str(plain[5].metering) == str(frames[5].metering)


def test_its_settings_are_checked_by_itself_and_have_a_place(declared, study):
    with pytest.raises(InputError, match=r"sensors.yaml:\d+: sigma_m=-1 must be >= 0"):
        load(with_entry(study, "range:\n  sigma_m: -1\n"))


def test_an_entry_that_nobody_declared_is_refused_with_the_nearest_name(declared, study):
    with pytest.raises(InputError, match=r"sensors.yaml:\d+: unknown key 'rnage' in .*; did you mean 'range'"):
        load(with_entry(study, "rnage:\n  sigma_m: 0.02\n"))


def test_a_required_sensor_that_is_missing_is_named(study):
    path = study / "sensors.yaml"
    path.write_text(path.read_text().replace("battery:", "batery:"))
    with pytest.raises(InputError, match="did you mean 'battery'"):
        load(study)
