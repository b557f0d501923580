"""The wire of a baseline with mutants watched alongside."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.mutants.operator import Occurrences, Tap, Windows
from scaloft_fi.mutants.sample import within
from scaloft_fi.mutants.watch import WatchingWire
from scaloft_fi.mutants.wire import SeamCount, TapError, TappedWire
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.stack.reference.messages import Target


def tapped(taps: Mapping[str, Tap]) -> TappedWire:
    return TappedWire((REFERENCE.by_name[seam], tap) for seam, tap in taps.items())


Delivery = tuple[str, float, Any]


def _from(at_s: float) -> Callable[[float, Any], Any]:
    """A tap that sends the drone home from `at_s` on."""
    return lambda t_s, sample: sample._replace(point=(0.0, 0.0, 1.65)) if sample and t_s >= at_s else sample


def _broken(_t_s: float, _sample: Any) -> Any:
    raise ZeroDivisionError("tap")


def _taps() -> dict[str, dict[str, Callable[[float, Any], Any]]]:
    return {"early": {"target": _from(0.1)}, "late": {"target": _from(0.3)}, "never": {"target": _from(9.0)}}


POLLS = [("target", k / 20, Target(0, (1.0, float(k), 1.65))) for k in range(10)]


def _fly(wire: Any, polls: Iterable[Delivery] = tuple(POLLS)) -> list[Any]:
    return [wire.cross(seam, t_s, sample) for seam, t_s, sample in polls]


class Fork:
    """Splits nothing off: it is told in which branch to go on."""

    def __init__(self, taken: str = "") -> None:
        self.taken, self.asked = taken, list[str]()

    def __call__(self, name: str, t_s: float) -> bool:
        self.asked.append(name)
        return name == self.taken


def _watching(
    fork: Callable[[str, float], bool], taps: dict[str, Any], failures: list[str] | None = None
) -> WatchingWire:
    wires = {name: tapped(seams) for name, seams in taps.items()}
    told: list[str] = [] if failures is None else failures
    return WatchingWire(wires, fork, lambda name, error: told.append(f"{name}: {error}"))


def test_the_trunk_carries_every_sample_as_it_is_and_counts_nothing() -> None:
    wire = _watching(Fork(), _taps())
    assert all(delivered is sample for delivered, (*_, sample) in zip(_fly(wire), POLLS, strict=True))
    assert wire.counts == {}


def test_each_mutant_leaves_once_where_it_first_differs() -> None:
    seen = []
    _fly(_watching(lambda name, t_s: bool(seen.append((name, t_s))), _taps()))
    assert seen == [("early", 0.1), ("late", 0.3)]


def test_what_never_differs_is_told_with_what_it_carried() -> None:
    wire = _watching(Fork(), _taps())
    _fly(wire)
    assert wire.silent == {"never": {"target": SeamCount(10, 0, None)}}


@pytest.mark.parametrize("taken", ["early", "late"])
def test_a_branch_delivers_and_counts_what_a_flight_from_take_off_would(taken: str) -> None:
    wire, whole = _watching(Fork(taken), _taps()), tapped(_taps()[taken])
    assert _fly(wire) == _fly(whole)
    assert wire.counts == whole.counts
    assert wire.silent == {}


def test_in_a_branch_nobody_else_leaves() -> None:
    fork = Fork("early")
    _fly(_watching(fork, _taps()))
    assert fork.asked == ["early"]


def test_two_that_differ_at_once_leave_one_after_the_other_in_order() -> None:
    fork = Fork()
    _fly(_watching(fork, {"b": {"target": _from(0.0)}, "a": {"target": _from(0.0)}}))
    assert fork.asked == ["b", "a"]


def test_a_tap_that_fails_while_watched_is_that_mutants_failure_alone() -> None:
    failures: list[str] = []
    fork = Fork()
    wire = _watching(fork, {"bad": {"target": _broken}, **_taps()}, failures)
    assert _fly(wire) == [sample for *_, sample in POLLS]
    assert failures == ["bad: tap on target at 0.000 s: ZeroDivisionError: tap"]
    assert fork.asked == ["early", "late"]


def test_a_flight_that_cannot_branch_is_a_matter_of_the_harness() -> None:
    def refuse(_name: str, _t_s: float) -> bool:
        raise OSError("no more processes")

    with pytest.raises(TapError, match="branch of early: OSError: no more processes"):
        _fly(_watching(refuse, _taps()))


@given(
    polls=st.lists(st.tuples(st.sampled_from(("target", "depth")), st.sampled_from((None, 1.0, 2.0))), max_size=30),
    starts=st.lists(st.tuples(st.sampled_from(("target", "depth")), st.integers(0, 30)), min_size=1, max_size=5),
)
def test_whatever_is_sent_each_branch_is_the_flight_from_take_off(
    polls: list[tuple[str, float | None]], starts: list[tuple[str, int]]
) -> None:
    sent: list[Delivery] = [
        (seam, k / 20, None if value is None else Target(0, (value, 0.0, 0.0))) for k, (seam, value) in enumerate(polls)
    ]
    taps = {str(i): {seam: _from(k / 20)} for i, (seam, k) in enumerate(starts)}
    trunk = Fork()
    watching = _watching(trunk, taps)
    baseline = _fly(watching, sent)
    assert baseline == [sample for *_, sample in sent]
    for name, seams in taps.items():
        whole, branch = tapped(seams), _watching(Fork(name), taps)
        assert _fly(branch, sent) == _fly(whole, sent)
        assert (name in trunk.asked) == whole.altered
        assert (branch.counts if whole.altered else watching.silent[name]) == whole.counts


def test_it_listens_where_a_watched_wire_does_and_in_a_branch_where_that_one_does() -> None:
    taps = {**_taps(), "shaky": {"imu": lambda _t_s, sample: sample}}
    trunk, branch = _watching(Fork(), taps), _watching(Fork("early"), taps)
    for wire in (trunk, branch):
        assert wire.listens("imu")
        assert wire.listens("target")
        assert not wire.listens("thrust")
        _fly(wire)
    assert trunk.listens("imu")
    assert branch.listens("target")
    assert not branch.listens("imu")


def test_nobody_listens_where_all_have_left() -> None:
    wire = _watching(Fork(), {"early": {"imu": lambda _t_s, _sample: None}})
    assert wire.listens("imu")
    wire.cross("imu", 0.0, (0.0,))
    assert not wire.listens("imu")


def _at_events() -> dict[str, TappedWire]:
    """Two wires whose taps change the first sample after the events `sight` and `mode`."""

    def wire(event: str) -> TappedWire:
        occurrences = Occurrences()
        windows = Windows(occurrences.openings(0.0), 0.05)
        tap = within(windows, lambda target: target._replace(point=(0.0, 0.0, 1.65)))
        return TappedWire([(REFERENCE.by_name["target"], tap)], {event: occurrences})

    return {event: wire(event) for event in ("sight", "mode")}


def _fly_events(wire: Any, occurs: Mapping[int, str]) -> list[Any]:
    sent = []
    for k, (seam, t_s, sample) in enumerate(POLLS):
        if k in occurs:
            wire.occur(occurs[k], t_s)
        sent.append(wire.cross(seam, t_s, sample))
    return sent


@given(
    st.dictionaries(st.integers(0, 9), st.sampled_from(["sight", "mode", "light"])), st.sampled_from(["sight", "mode"])
)
def test_every_watched_wire_learns_of_its_event_and_a_branch_of_those_to_come(
    occurs: dict[int, str], taken: str
) -> None:
    fork = Fork(taken)
    wire, whole = WatchingWire(_at_events(), fork, lambda _name, _error: None), _at_events()[taken]
    assert wire.awaited == {"sight", "mode"}
    assert _fly_events(wire, occurs) == _fly_events(whole, occurs)
    assert wire.counts == (whole.counts if whole.altered else {})


def test_wires_of_faults_that_strike_at_times_await_no_event() -> None:
    assert _watching(Fork(), _taps()).awaited == frozenset()
