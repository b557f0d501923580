"""From the matrix to mutants."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.hazop.matrix import Cell, CellStatus, Expected, Fault, Guideword, Magnitude, Matrix, Parameter
from scaloft_fi.mutants.catalogue import defaults, derive, expected_of, realise, with_events
from scaloft_fi.mutants.operator import Facts, Hold, Period, Seconds, Tap, TapContext, Windows
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.mutants.wire import contexts, wire_for
from scaloft_fi.stack.messages import Detections
from scaloft_fi.stack.reference.declaration import REFERENCE

FACTS = Facts(settings={"memory": {"voxel_m": 0.15}})


def a_matrix(*faults: Fault) -> Matrix:
    """One cell NO-human with `faults`, and one that is not meaningful."""
    words = (Guideword("NO", "NO", "nothing"), Guideword("EARLY", "EARLY", "too early"))
    cells = {
        ("NO", "human"): Cell("NO", "human", CellStatus.CREDIBLE, "never seen", ("dead",), "fast", ("SR2",), faults),
        ("EARLY", "human"): Cell("EARLY", "human", CellStatus.NOT_MEANINGFUL, reason="no time machine"),
    }
    return Matrix(words, (Parameter("human", "person", "is seen", "detector", "-"),), cells)


BURSTS = Fault(
    "person", "outage", {"period_s": 10.0}, Magnitude("burst_s", "s", (1.0, 3.0), 3.0), phases=True, message=Detections
)
SHARES = Fault("person", "drop", {}, Magnitude("share", "%", (25.0, 100.0), 100.0, 0.01), message=Detections)


def test_mutants_come_in_the_order_fault_magnitude_phase() -> None:
    assert [mutant.id for mutant in derive(a_matrix(BURSTS, SHARES))] == [
        "NO-human@1s",
        "NO-human@1s#2.5s",
        "NO-human@1s#5s",
        "NO-human@1s#7.5s",
        "NO-human@3s",
        "NO-human@3s#2.5s",
        "NO-human@3s#5s",
        "NO-human@3s#7.5s",
        "NO-human@25%",
        "NO-human@100%",
    ]


def test_the_default_is_the_first_fault_at_its_default_unshifted() -> None:
    assert [mutant.id for mutant in defaults(a_matrix(BURSTS, SHARES))] == ["NO-human@3s"]
    assert realise(a_matrix(BURSTS, SHARES), "NO-human").id == "NO-human@3s"


def test_the_unit_picks_the_fault_and_the_ladder_is_no_limit() -> None:
    matrix = a_matrix(BURSTS, SHARES)
    assert realise(matrix, "NO-human@2.50s#01s").id == "NO-human@2.5s#1s"
    assert realise(matrix, "NO-human@2.5s#1s").arguments == {"period_s": 10.0, "burst_s": 2.5, "phase_s": 1.0}
    assert realise(matrix, "NO-human@70%").arguments == {"share": 0.7}


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("NO-human@120%", "mutant 'NO-human@120%': operator 'drop': share=1.2 must be >= 0 and <= 1"),
        ("NO-human@3m", "mutant 'NO-human@3m': '3m' is no magnitude of NO-human; did you mean 'NO-human@3s'?"),
        ("NO-human@all", "'all' is no magnitude of NO-human"),
        ("NO-human@25%#5s", "NO-human has no phase; write 'NO-human@25%'"),
        ("EARLY-human", "mutant 'EARLY-human' does not exist; the cell is not meaningful: no time machine"),
        ("NO-humna", "no cell 'NO-humna'; did you mean 'NO-human'?"),
    ],
)
def test_an_id_that_means_nothing_is_refused_with_the_reason(text: str, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        realise(a_matrix(BURSTS, SHARES), text)
    assert sentence in str(caught.value)


EVENTS = {"sight": "", "recoil": "", "light": "world.yaml has no happening of kind light"}
FLAGS = Fault(
    "person", "outage", {"burst_s": 1.0}, Magnitude("period_s", "s", (20.0, 5.0), 20.0), phases=True, message=Detections
)


def test_the_catalogue_has_the_events_that_can_come_after_the_times_of_each_magnitude() -> None:
    assert [mutant.id for mutant in derive(with_events(a_matrix(BURSTS), EVENTS))][4:8] == [
        "NO-human@1s#sight",
        "NO-human@1s#recoil",
        "NO-human@3s",
        "NO-human@3s#2.5s",
    ]


def test_where_magnitudes_are_periods_the_catalogue_has_events_at_the_default_only() -> None:
    matrix = with_events(a_matrix(FLAGS), EVENTS)
    assert [m.id for m in derive(matrix) if m.event] == ["NO-human@20s#sight", "NO-human@20s#recoil"]
    assert realise(matrix, "NO-human@5s#sight").arguments == {"burst_s": 1.0, "period_s": 5.0}


def test_events_change_no_default_and_no_mutant_that_strikes_at_times() -> None:
    matrix = a_matrix(BURSTS, SHARES)
    struck = with_events(matrix, EVENTS)
    assert defaults(struck) == defaults(matrix)
    assert tuple(mutant for mutant in derive(struck) if not mutant.event) == derive(matrix)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("NO-human@1s#sihgt", "mutant 'NO-human@1s#sihgt': no event 'sihgt'; did you mean 'sight'?"),
        (
            "NO-human#light",
            "mutant 'NO-human#light': the event 'light' cannot come: world.yaml has no happening of kind light",
        ),
        ("NO-human@25%#sight", "mutant 'NO-human@25%#sight': NO-human has no phase; write 'NO-human@25%'"),
    ],
)
def test_an_event_that_cannot_come_is_refused_in_a_sentence(text: str, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        realise(with_events(a_matrix(BURSTS, SHARES), EVENTS), text)
    assert str(caught.value) == sentence


def test_an_operator_that_opens_no_windows_at_events_strikes_at_times_only(monkeypatch: pytest.MonkeyPatch) -> None:
    def deafened(_context: TapContext, *, burst_s: Hold, period_s: Period = 20.0, phase_s: Seconds = 0.0) -> Tap:
        windows = Windows.periodic(period_s, phase_s, burst_s)
        return lambda t_s, sample: None if windows.open(t_s) else sample

    monkeypatch.setitem(OPERATORS._entries, "outage", replace(OPERATORS["outage"], make=deafened))
    matrix = with_events(a_matrix(BURSTS), EVENTS)
    assert not [mutant for mutant in derive(matrix) if mutant.event]
    with pytest.raises(InputError, match="operator 'outage' strikes at times only, such as #5s"):
        realise(matrix, "NO-human#sight")


def test_every_fault_of_the_reference_study_with_phases_strikes_at_events(matrix: Matrix) -> None:
    phased = {fault.operator for cell in matrix for fault in cell.faults if fault.phases}
    assert phased == {fault.operator for cell in matrix for fault in cell.faults if fault.events}
    assert {m.event for m in derive(matrix)} == {"", "sight", "obstacle", "waypoint", "person", "recoil", "mode"}


PLACES = {"operator": "human.yaml:7", "seam": "human.yaml:6", "share": "human.yaml:9", "delay_s": "human.yaml:9"}


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"operator": "dorp"}, "human.yaml:7: no operator 'dorp'; did you mean 'drop'?"),
        ({"seam": "depth", "operator": "deaf_"}, "human.yaml:7: no operator 'deaf_'; did you mean 'deaf'?"),
        (
            {"operator": "mirror", "arguments": {}},
            "human.yaml:6: operator 'mirror' needs an image, but seam 'person' carries Detections",
        ),
        ({"arguments": {"share": -1.0}}, "human.yaml:9: operator 'drop': share=-1 must be >= 0 and <= 1"),
        ({"arguments": {"shar": 1.0}}, "human.yaml:5: operator 'drop' has no argument 'shar'; did you mean 'share'?"),
        (
            {"operator": "delay", "arguments": {"delay_s": -3.0}},
            "human.yaml:9: operator 'delay': delay_s=-3 must be >= 0",
        ),
        ({"operator": "delay", "arguments": {}}, "human.yaml:7: operator 'delay' lacks the argument 'delay_s'"),
        ({"phases": True}, "human.yaml:5: operator 'drop' has no argument 'phase_s'"),
        (
            {"arguments": {}, "magnitude": Magnitude("share", "%", (150.0,), 150.0, 0.01, place="human.yaml:8")},
            "human.yaml:8: operator 'drop': share=1.5 must be >= 0 and <= 1",
        ),
    ],
)
def test_a_fault_that_cannot_be_made_is_refused_at_its_place(change: dict[str, Any], sentence: str) -> None:
    fault = {
        "seam": "person",
        "operator": "drop",
        "arguments": {"share": 1.0},
        "place": "human.yaml:5",
        "places": PLACES,
        "message": Detections,
    }
    with pytest.raises(InputError) as caught:
        derive(a_matrix(Fault(**(fault | change))))
    assert str(caught.value).startswith(sentence)


def test_what_is_expected_of_a_mutant_is_found_again() -> None:
    known = Expected("nobody is there", (25.0,))
    matrix = a_matrix(Fault("person", "drop", {}, SHARES.magnitude, expected=known, message=Detections))
    assert [expected_of(matrix, mutant) for mutant in derive(matrix)] == [known, None]


def test_every_credible_and_control_cell_of_the_study_has_mutants_that_patch_their_seam(matrix: Matrix) -> None:
    derived = derive(matrix)
    assert {mutant.cell for mutant in derived} == {c.name for c in matrix if c.status is not CellStatus.NOT_MEANINGFUL}
    assert {mutant.id for mutant in defaults(matrix)} <= {mutant.id for mutant in derived}
    assert len({mutant.id for mutant in derived}) == len(derived)
    for mutant in derived:
        assert mutant.operator in OPERATORS
        assert realise(matrix, mutant.id) == mutant
        wire = wire_for(mutant, REFERENCE, contexts(mutant.id, "T0O0W0D0H0", 0, FACTS))
        assert set(getattr(wire, "counts")) == {mutant.seam}  # noqa: B009 - the baseline's wire has none
