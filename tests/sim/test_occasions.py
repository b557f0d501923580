"""Events of a flight at which faults strike: when they occur, which can come, and that only taps learn of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from items import item_of
from tiny_stack import SOUND, Hop, hop

from scaloft_fi.document import load
from scaloft_fi.errors import InputError
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.mutants.operator import Facts
from scaloft_fi.mutants.wire import SeamCount, TappedWire, contexts, wire_for
from scaloft_fi.sim.events import TRUTH_EVENTS, Lookout, events_in, events_of
from scaloft_fi.sim.flight import fly
from scaloft_fi.sim.load import SimConfig
from scaloft_fi.sim.load import load as load_sim
from scaloft_fi.sim.log import FlightLog
from scaloft_fi.sim.stacks import StackChoice
from scaloft_fi.stack.declaration import Belief, Mark, PlainWire
from scaloft_fi.stack.reference.messages import BELIEFS

SIM = Path(__file__).parents[2] / "sim"
NAMES = ("person_sight_m", "clearance_rock_m", "waypoints_left", "light")
WORLD: Any = SimpleNamespace(bodies_with=lambda _trait: ("rock",))


class Told:
    """A wire that notes what it is told."""

    def __init__(self, *awaited: str) -> None:
        self.awaited = frozenset(awaited)
        self.occurred: list[tuple[str, float]] = []

    def occur(self, event: str, t_s: float) -> None:
        self.occurred.append((event, t_s))


def told(rows: Sequence[Sequence[float]], *awaited: str) -> list[tuple[str, float]]:
    wire = Told(*awaited)
    lookout = Lookout(wire, WORLD, NAMES, ())
    for k, row in enumerate(rows):
        lookout.look(float(k), row, ())
    return wire.occurred


FAR = (100.0, 1.0, 2.0, 0.9)


def changed(column: int, *values: float) -> list[tuple[float, ...]]:
    """Rows of which one column has these values."""
    return [(*FAR[:column], value, *FAR[column + 1 :]) for value in values]


@pytest.mark.parametrize(
    ("event", "rows", "at_s"),
    [
        ("sight", changed(0, 100.0, 3.1, 3.0, 2.0, 100.0, 1.0), [2.0]),
        ("sight", changed(0, 2.0, 2.0), [0.0]),
        ("obstacle", changed(1, 1.0, 0.99, 0.5, 1.0, 0.9), [1.0, 4.0]),
        ("waypoint", changed(2, 2.0, 2.0, 1.0, 1.0, 0.0), [2.0, 4.0]),
        ("light", changed(3, 0.9, 0.9, 0.5, 0.1, 0.1, 0.9), [2.0, 5.0]),
    ],
)
def test_an_event_of_the_truth_occurs_at_these_samples(event: str, rows: Any, at_s: list[float]) -> None:
    assert told(rows, event) == [(event, t_s) for t_s in at_s]


def test_a_wire_is_told_of_nothing_that_its_taps_do_not_await() -> None:
    assert told(changed(2, 2.0, 1.0), "sight", "light") == []
    assert Lookout.of(PlainWire(), WORLD, NAMES, ()) is None
    assert Lookout.of(Told(), WORLD, NAMES, ()) is None


@given(st.lists(st.sampled_from([0.0, 0.4, 1.0, 2.0]), min_size=1, max_size=30), st.booleans(), st.booleans())
def test_an_event_of_a_belief_occurs_where_the_log_has_its_mark(values: list[float], named: bool, first: bool) -> None:
    belief = Belief("hunch", "", "", mark=Mark("hunch", "{}", first, ("a", "b", "c") if named else ()))
    wire = Told("hunch")
    lookout = Lookout(wire, WORLD, NAMES, (Belief("other", "", ""), belief))
    for k, value in enumerate(values):
        lookout.look(k / 20, FAR, (0.0, value))
    elapsed_s = np.arange(len(values)) / 20
    marks = events_of(elapsed_s, [belief], {"hunch": np.array(values)}, {}, "", 0.0, "")
    assert wire.occurred == [("hunch", mark.t_s) for mark in marks]


def test_the_reference_study_has_events_of_truth_and_of_its_stack_and_no_change_of_light() -> None:
    events = events_in(load(SIM / "world.yaml"), BELIEFS)
    assert [name for name, why_not in events.items() if not why_not] == [
        "sight",
        "obstacle",
        "waypoint",
        "person",
        "recoil",
        "mode",
    ]
    assert events["light"] == f"{SIM / 'world.yaml'} has no happening of kind light"


def test_bodies_and_happenings_of_a_world_decide_which_events_can_come(tmp_path: Path) -> None:
    path = tmp_path / "world.yaml"
    path.write_text("bodies: {bar: {role: structure}}\nhappenings: {lamp: {kind: light}}\n")
    assert [name for name, why_not in events_in(load(path), ()).items() if why_not] == ["sight", "obstacle"]
    path.write_text("bodies:\n  bar: {}\n")
    with pytest.raises(InputError, match=r"world.yaml:2: "):
        events_in(load(path), ())


def test_a_mark_whose_kind_no_id_can_hold_is_no_event_and_one_named_as_the_truth_is_the_truth() -> None:
    marks = [Belief(kind, "", "", mark=Mark(kind, "")) for kind in ("Leg 2", "waypoint", "leg")]
    assert list(events_in(load(SIM / "world.yaml"), marks)) == [*TRUTH_EVENTS, "leg"]


class Switching(Hop):
    """Believes to be in mode 0 on the ground, 1 from 1.5 s on, 2 from 4 s on."""

    def beliefs(self, now_s: float) -> Any:
        return np.array([now_s, (now_s >= 1.5) + (now_s >= 4.0)])


MODE = Belief("mode", "", "what it does", mark=Mark("mode", "{}", values=("rest", "hover", "sink")))
HOP = hop(Switching, beliefs=(SOUND.beliefs[0], MODE))


def struck_at(config: SimConfig, event: str) -> tuple[FlightLog, SeamCount]:
    """A hop of which 0.1 s of levels are lost at each occurrence of the event, and what was lost."""
    arguments = {"burst_s": 0.1, "period_s": 1.0}
    mutant = Mutant(f"NO-level#{event}", "NO", "level", "", 0.0, "level", "outage", arguments, event)
    wire = wire_for(mutant, HOP, contexts(mutant.id, "T0O0W0D0H0", 0, Facts()))
    assert isinstance(wire, TappedWire)
    study = replace(config, stack=StackChoice.read(item_of({"name": "hop", "mass_kg": 1.5})))
    return fly(study, config.grid.situation("T0O0W0D0H0"), 0, wire, HOP), wire.counts["level"]


@pytest.mark.flight
def test_a_fault_strikes_a_stack_of_ones_own_at_each_change_of_mode(config: SimConfig) -> None:
    log, lost = struck_at(config, "mode")
    assert [event.t_s for event in log.events if event.kind == "mode"] == pytest.approx([1.5, 4.0])
    assert (lost.first_altered_s, lost.altered) == (pytest.approx(1.5), 4)


@pytest.mark.flight
def test_a_fault_strikes_when_the_light_of_a_world_begins_to_change(edited: Callable[[str, str, str], Path]) -> None:
    lamp = "happenings: {lamp: {kind: light, active: true, light: 0.1, start: {at_s: 2}, lasts_s: 1}}\n\nbodies:\n"
    config = load_sim(edited("world.yaml", "bodies:\n", lamp))
    log, lost = struck_at(config, "light")
    changes = np.flatnonzero(np.diff(log.signals["light"])) + 1
    assert log.signals["elapsed_s"][changes].tolist() == pytest.approx([2.0, 3.05])
    assert (lost.first_altered_s, lost.altered) == (pytest.approx(2.0), 4)
