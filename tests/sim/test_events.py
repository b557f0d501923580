"""Events of a flight, on its map and at which faults strike: when they occur, which can come, who learns of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from studies import item_of
from tiny_stack import SOUND, Hop, hop

from scaloft_fi.document import load
from scaloft_fi.errors import InputError
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.mutants.operator import Facts
from scaloft_fi.mutants.wire import SeamCount, contexts, wire_for
from scaloft_fi.sim.events import TRUTH_EVENTS, Lookout, events_in, events_of
from scaloft_fi.sim.flight import fly
from scaloft_fi.sim.load import load as load_sim
from scaloft_fi.sim.stacks import StackChoice
from scaloft_fi.stack.declaration import Belief, Mark, PlainWire
from scaloft_fi.stack.reference.messages import BELIEFS
from tests.sim.conftest import SIM

NAMES = ("person_sight_m", "clearance_rock_m", "waypoints_left", "light")
FAR = (100.0, 1.0, 2.0, 0.9)
WORLD: Any = SimpleNamespace(bodies_with=lambda _trait: ("rock",))


def events(mark, values, **facts):
    belief, elapsed_s = Belief("hunch", "", "a hunch", mark=mark), np.arange(len(values)) / 20
    rest = {"counts": {}, "struck": "", "struck_at_s": 0.0, "error": ""} | facts
    return [(e.t_s, e.kind, e.text) for e in events_of(elapsed_s, [belief], {"hunch": np.array(values)}, **rest)]


@pytest.mark.parametrize(
    ("mark", "values", "marked"),
    [
        (None, [0, 1, 0, 1, 0, 1], []),
        (Mark("seen", "sees"), [0, 1, 1, 0, 1, 0], [0.05, 0.2]),
        (Mark("seen", "sees"), [1, 1, 1, 0, 1, 0], [0.0, 0.2]),
        (Mark("seen", "sees", first=True), [0, 1, 0, 0, 1, 0], [0.05]),
        (Mark("seen", "sees"), [0.5, 0.5, 0.51, 0, 0, 0], [0.1]),
    ],
)
def test_a_marked_belief_marks_each_rise_or_the_first(mark, values, marked):
    assert [t_s for t_s, _, _ in events(mark, values)] == pytest.approx(marked)


def test_a_belief_with_named_values_marks_each_change_with_the_name():
    marked = events(Mark("mode", "now {}", values=("idle", "climb", "land")), [0, 1, 1, 2, 2, 0])
    assert [t_s for t_s, *_ in marked] == pytest.approx([0.05, 0.15, 0.25])
    assert [text for *_, text in marked] == ["now climb", "now land", "now idle"]


def test_infection_contact_and_error_stand_in_the_order_of_time():
    counts = {"imu": SeamCount(9, 2, 0.12), "depth": SeamCount(3, 1, 0.02), "fix": SeamCount(4, 0, None)}
    facts = {"counts": counts, "struck": "wall", "struck_at_s": 0.07, "error": "ValueError at 0.200 s: odd"}
    found = events(Mark("seen", "sees"), [0, 1, 1, 1, 1, 1], **facts)
    assert [kind for _, kind, _ in found] == ["infection", "seen", "contact", "error"]
    assert [t_s for t_s, _, _ in found] == pytest.approx([0.02, 0.05, 0.07, 0.2])


class Told:
    """A wire that notes what it is told."""

    def __init__(self, *awaited: str) -> None:
        self.awaited = frozenset(awaited)
        self.occurred: list[tuple[str, float]] = []

    def occur(self, event: str, t_s: float) -> None:
        self.occurred.append((event, t_s))


def told(wire: Told, column: int, values: Sequence[float]) -> list[tuple[str, float]]:
    lookout = Lookout(wire, WORLD, NAMES, ())
    for k, value in enumerate(values):
        lookout.look(float(k), (*FAR[:column], value, *FAR[column + 1 :]), ())
    return wire.occurred


@pytest.mark.parametrize(
    ("event", "column", "values", "at_s"),
    [
        ("sight", 0, (100.0, 3.1, 3.0, 2.0, 100.0, 1.0), [2.0]),
        ("sight", 0, (2.0, 2.0), [0.0]),
        ("obstacle", 1, (1.0, 0.99, 0.5, 1.0, 0.9), [1.0, 4.0]),
        ("waypoint", 2, (2.0, 2.0, 1.0, 1.0, 0.0), [2.0, 4.0]),
        ("light", 3, (0.9, 0.9, 0.5, 0.1, 0.1, 0.9), [2.0, 5.0]),
    ],
)
def test_an_event_of_the_truth_occurs_at_these_samples(event, column, values, at_s):
    assert told(Told(event), column, values) == [(event, t_s) for t_s in at_s]


def test_a_wire_is_told_of_nothing_that_its_taps_do_not_await():
    assert told(Told("sight", "light"), 2, (2.0, 1.0)) == []
    assert Lookout.of(PlainWire(), WORLD, NAMES, ()) is None
    assert Lookout.of(Told(), WORLD, NAMES, ()) is None


@given(st.lists(st.sampled_from([0.0, 0.4, 1.0, 2.0]), min_size=1, max_size=30), st.booleans(), st.booleans())
def test_an_event_of_a_belief_occurs_where_the_log_has_its_mark(values, named, first):
    mark = Mark("hunch", "{}", first, ("a", "b", "c") if named else ())
    wire = Told("hunch")
    lookout = Lookout(wire, WORLD, NAMES, (Belief("other", "", ""), Belief("hunch", "", "", mark=mark)))
    for k, value in enumerate(values):
        lookout.look(k / 20, FAR, (0.0, value))
    assert wire.occurred == [("hunch", t_s) for t_s, _, _ in events(mark, values)]


def test_bodies_happenings_and_marks_of_a_study_decide_which_events_can_come(tmp_path):
    found = events_in(load(SIM / "world.yaml"), BELIEFS)
    can = [name for name, why_not in found.items() if not why_not]
    assert can == ["sight", "obstacle", "waypoint", "person", "recoil", "mode"]
    assert found["light"] == f"{SIM / 'world.yaml'} has no happening of kind light"
    # a mark whose kind no id can hold is no event, and one named as the truth is the truth
    marks = [Belief(kind, "", "", mark=Mark(kind, "")) for kind in ("Leg 2", "waypoint", "leg")]
    assert list(events_in(load(SIM / "world.yaml"), marks)) == [*TRUTH_EVENTS, "leg"]
    path = tmp_path / "world.yaml"
    path.write_text("bodies: {bar: {role: structure}}\nhappenings: {lamp: {kind: light}}\n")
    assert [name for name, why_not in events_in(load(path), ()).items() if why_not] == ["sight", "obstacle"]
    path.write_text("bodies:\n  bar: {}\n")
    with pytest.raises(InputError, match=r"world.yaml:2: "):
        events_in(load(path), ())


class Switching(Hop):
    """Believes to be in mode 0 on the ground, 1 from 1.5 s on, 2 from 4 s on."""

    def beliefs(self, now_s: float) -> Any:
        return np.array([now_s, (now_s >= 1.5) + (now_s >= 4.0)])


MODE = Belief("mode", "", "what it does", mark=Mark("mode", "{}", values=("rest", "hover", "sink")))
HOP = hop(Switching, beliefs=(SOUND.beliefs[0], MODE))


def struck_at(config, event):
    """A hop of which 0.1 s of levels are lost at each occurrence of the event, and what was lost."""
    arguments = {"burst_s": 0.1, "period_s": 1.0}
    mutant = Mutant(f"NO-level#{event}", "NO", "level", "", 0.0, "level", "outage", arguments, event)
    wire = wire_for(mutant, HOP, contexts(mutant.id, "T0O0W0D0H0", 0, Facts()))
    study = replace(config, stack=StackChoice.read(item_of({"name": "hop", "mass_kg": 1.5})))
    return fly(study, config.grid.situation("T0O0W0D0H0"), 0, wire, HOP), wire.counts["level"]


@pytest.mark.flight
def test_a_fault_strikes_a_stack_of_ones_own_at_each_change_of_mode(config):
    log, lost = struck_at(config, "mode")
    assert [event.t_s for event in log.events if event.kind == "mode"] == pytest.approx([1.5, 4.0])
    assert (lost.first_altered_s, lost.altered) == (pytest.approx(1.5), 4)


@pytest.mark.flight
def test_a_fault_strikes_when_the_light_of_a_world_begins_to_change(edited):
    lamp = "happenings: {lamp: {kind: light, active: true, light: 0.1, start: {at_s: 2}, lasts_s: 1}}\n\nbodies:\n"
    log, lost = struck_at(load_sim(edited("world.yaml", "bodies:\n", lamp)), "light")
    changes = np.flatnonzero(np.diff(log.signals["light"])) + 1
    assert log.signals["elapsed_s"][changes].tolist() == pytest.approx([2.0, 3.05])
    assert (lost.first_altered_s, lost.altered) == (pytest.approx(2.0), 4)
