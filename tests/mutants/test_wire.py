"""The wires of a flight."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import nullcontext
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.mutants.catalogue import defaults, realise, source_of
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.mutants.operator import Facts, Occurrences, Tap, TapContext, TapError, Windows
from scaloft_fi.mutants.sample import within
from scaloft_fi.mutants.wire import SeamCount, TappedWire, WatchingWire, contexts, wire_for
from scaloft_fi.stack.declaration import PlainWire, Seam
from scaloft_fi.stack.messages import DepthFrame
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.stack.reference.messages import ObstacleMap, Target

CONTEXT = contexts("PLACEBO", "T0O0W0D0H0", 0, Facts())


def test_the_baseline_flies_on_a_plain_wire():
    assert isinstance(wire_for(None, REFERENCE, CONTEXT), PlainWire)


def test_placebo_passes_every_sample_of_every_seam_through_a_tap_and_alters_none(stream: Any):
    wire = wire_for(PLACEBO, REFERENCE, CONTEXT)
    assert isinstance(wire, TappedWire)
    for seam in REFERENCE.by_name:
        for t_s, sample in stream(seam):
            assert wire.cross(seam, t_s, sample) is sample
    assert set(wire.counts) == set(REFERENCE.by_name)
    assert set(wire.counts.values()) == {SeamCount(carried=30, altered=0, first_altered_s=None)}


def test_only_the_tapped_seam_is_altered_and_counted(matrix: Matrix, stream: Any):
    wire = wire_for(realise(matrix, "LATE-human@0.5s"), REFERENCE, CONTEXT)
    assert isinstance(wire, TappedWire)
    for t_s, sample in stream("depth"):
        assert wire.cross("depth", t_s, sample) is sample
    sent = 0
    for t_s, sample in stream("person"):
        wire.cross("person", t_s, sample)
        sent += sample is not None
    assert wire.counts["person"].altered > 0
    assert wire.counts["person"].first_altered_s == 0.0
    assert wire.counts["person"].carried >= sent
    assert set(wire.counts) == {"person"}


def test_a_sample_made_from_nothing_was_carried_and_is_altered(matrix: Matrix):
    wire = wire_for(realise(matrix, "UNINTENDED-human@5s"), REFERENCE, CONTEXT)
    assert isinstance(wire, TappedWire)
    for k in range(20 * 6):
        wire.cross("person", k / 20, None)
    assert wire.counts["person"] == SeamCount(carried=20, altered=20, first_altered_s=5.0)


def test_a_tap_that_delivers_another_type_than_the_seams_message_fails():
    wire = tapped({"target": lambda _t_s, _sample: "wrong"})
    with pytest.raises(TapError, match=r"tap on target at 0\.050 s: TypeError: it delivers str, not Target or None"):
        wire.cross("target", 0.05, Target(0, (0.0, 0.0, 0.0)))


@pytest.mark.parametrize(
    ("field", "shape", "fits"),
    [("depth", (3, 3), False), ("depth", (12,), False), ("points", (5, 3), True), ("points", (2, 2), False)],
)
def test_an_array_of_another_shape_than_was_sent_never_reaches_a_compiled_stage(
    field: str, shape: tuple[int, ...], fits: bool
):
    seam, sent = {
        "depth": ("depth", DepthFrame(0.0, np.ones((4, 3)))),
        "points": ("map", ObstacleMap(0.0, np.ones((2, 3)), 1.0, np.zeros(3))),
    }[field]
    wire = TappedWire([(REFERENCE.by_name[seam], lambda _t_s, sample: sample._replace(**{field: np.zeros(shape)}))])
    with nullcontext() if fits else pytest.raises(TapError, match=rf"{field} has the shape .*, and .* was sent"):
        wire.cross(seam, 0.05, sent)


def test_a_failing_tap_is_a_matter_of_the_harness():
    wire = tapped({"target": _broken})
    with pytest.raises(TapError, match=r"tap on target at 0\.050 s: ZeroDivisionError: tap") as failed:
        wire.cross("target", 0.05, Target(0, (0.0, 0.0, 0.0)))
    assert failed.value.declared_in == __name__


def test_a_tap_that_would_end_the_process_fails_alone():
    def leave(_t_s: float, _sample: Any) -> Any:
        raise SystemExit(3)

    with pytest.raises(TapError, match=r"tap on target at 0\.050 s: SystemExit: 3"):
        tapped({"target": leave}).cross("target", 0.05, Target(0, (0.0, 0.0, 0.0)))


def test_randomness_depends_on_mutant_situation_and_seed_only():
    def draws(mutant_id: str, situation: str, seed: int) -> list[float]:
        return list(contexts(mutant_id, situation, seed, Facts())(REFERENCE.by_name["depth"]).rng.random(3))

    reference = draws("NO-depth@50%", "T0O0W0D0H0", 0)
    assert draws("NO-depth@50%", "T0O0W0D0H0", 0) == reference
    assert draws("NO-depth@25%", "T0O0W0D0H0", 0) != reference
    assert draws("NO-depth@50%", "T1O0W0D0H0", 0) != reference
    assert draws("NO-depth@50%", "T0O0W0D0H0", 1) != reference


def test_a_wire_copied_in_flight_counts_for_itself(matrix: Matrix, stream: Any):
    wire = wire_for(realise(matrix, "NO-depth@50%"), REFERENCE, contexts("NO-depth@50%", "T0O0W0D0H0", 0, Facts()))
    polls = stream("depth")
    for t_s, sample in polls[:20]:
        wire.cross("depth", t_s, sample)
    branch = copy.deepcopy(wire)
    rest = [branch.cross("depth", t_s, sample) is None for t_s, sample in polls[20:]]
    assert rest == [wire.cross("depth", t_s, sample) is None for t_s, sample in polls[20:]]
    assert np.any(rest)


def test_every_default_alters_what_its_seam_carries_unless_the_matrix_says_otherwise(matrix: Matrix, sample_of: Any):
    facts = Facts(sighting_s=12.0, settings={"memory": {"voxel_m": 0.15}})
    silent = []
    for mutant in defaults(matrix):
        wire = wire_for(mutant, REFERENCE, contexts(mutant.id, "T0O0W0D0H0", 0, facts))
        assert isinstance(wire, TappedWire)
        rate_hz = REFERENCE.by_name[mutant.seam].rate_hz
        for k in range(int(21 * rate_hz)):
            # one sample in three polls, and a long silence after a reduction of the speed limit
            sent = k % 3 == 0 and not 4.4 < k / rate_hz < 8.0
            sample = sample_of(mutant.seam, k % 16) if sent else None
            wire.cross(mutant.seam, k / rate_hz, sample)
        fault, rung = source_of(matrix, mutant)
        if not wire.counts[mutant.seam].altered and fault.expects(rung) is None:
            silent.append(mutant.id)
    assert silent == []


def tapped(taps: Mapping[str, Tap]) -> TappedWire:
    return TappedWire((Seam(seam, Target, 20.0, "here -> there"), tap) for seam, tap in taps.items())


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


def test_each_mutant_leaves_once_where_it_first_differs():
    seen = []
    _fly(_watching(lambda name, t_s: bool(seen.append((name, t_s))), _taps()))
    assert seen == [("early", 0.1), ("late", 0.3)]


def test_in_a_branch_nobody_else_leaves():
    fork = Fork("early")
    _fly(_watching(fork, _taps()))
    assert fork.asked == ["early"]


def test_two_that_differ_at_once_leave_one_after_the_other_in_order():
    fork = Fork()
    _fly(_watching(fork, {"b": {"target": _from(0.0)}, "a": {"target": _from(0.0)}}))
    assert fork.asked == ["b", "a"]


def test_a_tap_that_fails_while_watched_is_that_mutants_failure_alone():
    failures: list[str] = []
    fork = Fork()
    wire = _watching(fork, {"bad": {"target": _broken}, **_taps()}, failures)
    assert _fly(wire) == [sample for *_, sample in POLLS]
    assert failures == ["bad: tap on target at 0.000 s: ZeroDivisionError: tap"]
    assert fork.asked == ["early", "late"]


def test_a_flight_that_cannot_branch_is_a_matter_of_the_harness():
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
):
    sent: list[Delivery] = [
        (seam, k / 20, None if value is None else Target(0, (value, 0.0, 0.0))) for k, (seam, value) in enumerate(polls)
    ]
    taps = {str(i): {seam: _from(k / 20)} for i, (seam, k) in enumerate(starts)}
    trunk = Fork()
    watching = _watching(trunk, taps)
    baseline = _fly(watching, sent)
    assert all(delivered is sample for delivered, (*_, sample) in zip(baseline, sent, strict=True))
    assert watching.counts == {}
    for name, seams in taps.items():
        whole, branch = tapped(seams), _watching(Fork(name), taps)
        assert _fly(branch, sent) == _fly(whole, sent)
        assert (name in trunk.asked) == whole.altered
        assert (branch.counts if whole.altered else watching.silent[name]) == whole.counts


def test_it_listens_where_a_watched_wire_does_and_in_a_branch_where_that_one_does():
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


def test_nobody_listens_where_all_have_left():
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
def test_every_watched_wire_learns_of_its_event_and_a_branch_of_those_to_come(occurs: dict[int, str], taken: str):
    fork = Fork(taken)
    wire, whole = WatchingWire(_at_events(), fork, lambda _name, _error: None), _at_events()[taken]
    assert wire.awaited == {"sight", "mode"}
    assert _fly_events(wire, occurs) == _fly_events(whole, occurs)
    assert wire.counts == (whole.counts if whole.altered else {})


def test_wires_of_faults_that_strike_at_times_await_no_event():
    assert _watching(Fork(), _taps()).awaited == frozenset()


OCCURS = st.sets(st.integers(0, 400), max_size=30).map(sorted)
RATES = st.sampled_from([20, 240])


def opened(windows: Windows, event: Occurrences, occurs: list[int], rate_hz: int) -> dict[int, int]:
    """By poll at which a window is open its number; the event occurs at ticks (20 Hz), before the tick's polls."""
    found, per_tick = {}, rate_hz // 20
    for tick in range(450):
        if tick in occurs:
            event.occur(tick / 20)
        for poll in range(tick * per_tick, (tick + 1) * per_tick):
            number = windows.number(poll / rate_hz)
            if number is not None:
                found[poll] = number
    return found


@given(OCCURS, st.integers(1, 60), st.integers(1, 100), RATES)
def test_windows_open_at_occurrences_keep_their_length_and_do_not_overlap(
    occurs: list[int], length: int, apart: int, rate_hz: int
):
    event, per_tick, length = Occurrences(), rate_hz // 20, min(length, apart)
    windows = Windows(event.openings(apart / 20), length / 20)
    starts: list[int] = []
    for tick in occurs:
        if not starts or tick - starts[-1] >= apart:
            starts.append(tick)
    expected = {
        poll: number for number, s in enumerate(starts) for poll in range(s * per_tick, (s + length) * per_tick)
    }
    assert opened(windows, event, occurs, rate_hz) == {
        poll: number for poll, number in expected.items() if poll < 450 * per_tick
    }


@given(OCCURS, st.integers(1, 60))
def test_a_fault_that_happens_once_strikes_at_the_first_occurrence_only(occurs: list[int], length: int):
    event = Occurrences()
    windows = TapContext(0.05, np.random.default_rng(0), event=event).window(at_s=3.0, length_s=length / 20)
    polls = range(occurs[0], min(occurs[0] + length, 450)) if occurs else ()
    assert opened(windows, event, occurs, 20) == dict.fromkeys(polls, 0)


def test_without_an_event_a_context_opens_windows_at_times():
    context = TapContext(0.05, np.random.default_rng(0))
    assert context.windows(20.0, 5.0, 2.0) == Windows.periodic(20.0, 5.0, 2.0)
    assert [context.window(3.0, math.inf).number(t_s) for t_s in (2.95, 3.0, 1000.0)] == [None, 0, 0]


def test_a_copy_of_windows_learns_of_nothing_that_happens_to_the_original():
    event = Occurrences()
    windows = Windows(event.openings(0.0), 1.0)
    branch = copy.deepcopy(windows)
    event.occur(2.0)
    assert windows.open(2.0)
    assert not branch.open(2.0)
