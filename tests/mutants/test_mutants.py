"""From the matrix, or from what a user writes, to mutants."""

from __future__ import annotations

import json
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from options import as_recorded, cases
from refused import refusal

from scaloft_fi.errors import InputError
from scaloft_fi.hazop import matrix as matrices
from scaloft_fi.mutants import catalogue
from scaloft_fi.mutants.catalogue import default_of, defaults, derive, realise, select, source_of, with_events
from scaloft_fi.mutants.check_operator import check_operator
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.mutants.operator import Example, Facts, Hold, Period, Seconds, Tap, TapContext, Windows
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.mutants.wire import contexts, wire_for
from scaloft_fi.stack.messages import DepthFrame, Detections
from scaloft_fi.stack.reference.declaration import REFERENCE

FACTS = Facts(settings={"memory": {"voxel_m": 0.15}})


def a_matrix(*faults: matrices.Fault) -> matrices.Matrix:
    """One cell NO-human with `faults`, and one that is not meaningful."""
    words = (matrices.Guideword("NO", "NO", "nothing"), matrices.Guideword("EARLY", "EARLY", "too early"))
    cells = {
        ("NO", "human"): matrices.Cell(
            "NO", "human", matrices.CellStatus.CREDIBLE, "never seen", ("dead",), "fast", ("SR2",), faults
        ),
        ("EARLY", "human"): matrices.Cell(
            "EARLY", "human", matrices.CellStatus.NOT_MEANINGFUL, reason="no time machine"
        ),
    }
    return matrices.Matrix(words, (matrices.Parameter("human", "person", "is seen", "detector", "-"),), cells)


BURSTS = matrices.Fault(
    "person",
    "outage",
    {"period_s": 10.0},
    matrices.Magnitude("burst_s", "s", (1.0, 3.0), 3.0),
    phases=True,
    message=Detections,
)
SHARES = matrices.Fault(
    "person", "drop", {}, matrices.Magnitude("share", "%", (25.0, 100.0), 100.0, 0.01), message=Detections
)


def test_mutants_come_in_the_order_fault_magnitude_phase():
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


def test_the_default_is_the_first_fault_at_its_default_unshifted():
    assert [mutant.id for mutant in defaults(a_matrix(BURSTS, SHARES))] == ["NO-human@3s"]
    assert realise(a_matrix(BURSTS, SHARES), "NO-human").id == "NO-human@3s"


def test_the_unit_picks_the_fault_and_the_ladder_is_no_limit():
    matrix = a_matrix(BURSTS, SHARES)
    assert realise(matrix, "NO-human@2.50s#01s").id == "NO-human@2.5s#1s"
    assert realise(matrix, "NO-human@2.5s#1s").arguments == {"period_s": 10.0, "burst_s": 2.5, "phase_s": 1.0}
    assert realise(matrix, "NO-human@70%").arguments == {"share": 0.7}


EVENTS = {"sight": "", "recoil": "", "light": "world.yaml has no happening of kind light"}
FLAGS = matrices.Fault(
    "person",
    "outage",
    {"burst_s": 1.0},
    matrices.Magnitude("period_s", "s", (20.0, 5.0), 20.0),
    phases=True,
    message=Detections,
)


def test_the_catalogue_has_the_events_that_can_come_after_the_times_of_each_magnitude():
    assert [mutant.id for mutant in derive(with_events(a_matrix(BURSTS), EVENTS))][4:8] == [
        "NO-human@1s#sight",
        "NO-human@1s#recoil",
        "NO-human@3s",
        "NO-human@3s#2.5s",
    ]


def test_where_magnitudes_are_periods_the_catalogue_has_events_at_the_default_only():
    matrix = with_events(a_matrix(FLAGS), EVENTS)
    assert [m.id for m in derive(matrix) if m.event] == ["NO-human@20s#sight", "NO-human@20s#recoil"]
    assert realise(matrix, "NO-human@5s#sight").arguments == {"burst_s": 1.0, "period_s": 5.0}


def test_events_change_no_default_and_no_mutant_that_strikes_at_times():
    matrix = a_matrix(BURSTS, SHARES)
    struck = with_events(matrix, EVENTS)
    assert defaults(struck) == defaults(matrix)
    assert tuple(mutant for mutant in derive(struck) if not mutant.event) == derive(matrix)


def test_an_operator_whose_phase_shifts_windows_of_its_own_fails_its_check(monkeypatch: pytest.MonkeyPatch):
    def deafened(_context: TapContext, *, burst_s: Hold, period_s: Period = 20.0, phase_s: Seconds = 0.0) -> Tap:
        """Lose samples in windows."""
        windows = Windows.periodic(period_s, phase_s, burst_s)
        return lambda t_s, sample: None if windows.open(t_s) else sample

    assert check_operator("outage").failures == ()
    monkeypatch.setitem(OPERATORS._entries, "outage", replace(OPERATORS["outage"], make=deafened))
    assert ["phase_s" in failure for failure in check_operator("outage").failures] == [True]


def test_an_operator_that_writes_into_a_sample_or_changes_its_shape_fails_its_check(monkeypatch: pytest.MonkeyPatch):
    def clipped(_context: TapContext) -> Tap:
        """Let nothing be farther, in place."""
        return lambda _t_s, sample: sample._replace(depth=np.minimum(sample.depth, 1.5, out=sample.depth))

    def cut(_context: TapContext) -> Tap:
        """Lose the last column."""
        return lambda _t_s, sample: sample._replace(depth=sample.depth[:, :-1])

    sent = (DepthFrame(0.0, np.array([[1.0, 2.0]])),)
    own = replace(OPERATORS["mirror"], example=Example(DepthFrame, {}, sent, lambda _before, _after: True))
    for make, said in ((clipped, "read-only"), (cut, "depth has the shape (1, 1)")):
        monkeypatch.setitem(OPERATORS._entries, "mirror", replace(own, make=make))
        assert said in " ".join(check_operator("mirror").failures)


def test_every_fault_of_the_reference_study_with_phases_strikes_at_events(matrix: matrices.Matrix):
    phased = {fault.operator for cell in matrix for fault in cell.faults if fault.phases}
    assert phased == {fault.operator for cell in matrix for fault in cell.faults if fault.events}
    assert {m.event for m in derive(matrix)} == {"", "sight", "obstacle", "waypoint", "person", "recoil", "mode"}


WRONG: dict[str, dict[str, Any]] = {
    "an unknown operator": {"operator": "dorp"},
    "an unknown operator on another seam": {"seam": "depth", "operator": "deaf_"},
    "an operator that does not fit the seam": {"operator": "mirror", "arguments": {}},
    "a share below 0": {"arguments": {"share": -1.0}},
    "an unknown argument": {"arguments": {"shar": 1.0}},
    "a delay below 0": {"operator": "delay", "arguments": {"delay_s": -3.0}},
    "a missing argument": {"operator": "delay", "arguments": {}},
    "phases of an operator without": {"phases": True},
    "a rung out of range": {
        "arguments": {},
        "magnitude": matrices.Magnitude("share", "%", (150.0,), 150.0, 0.01, place="human.yaml:8"),
    },
}
"""What is wrong with a fault of the matrix, which stands in line 5."""
PLACES = {"operator": "human.yaml:7", "seam": "human.yaml:6", "share": "human.yaml:9", "delay_s": "human.yaml:9"}


def test_what_is_no_mutant_is_refused_with_the_reason_and_the_nearest_name(matrix: matrices.Matrix):
    small = a_matrix(BURSTS, SHARES)
    plain = "NO-human@120%", "NO-human@3m", "NO-human@all", "NO-human@25%#5s", "EARLY-human", "NO-humna"
    said = {text: refusal(realise, small, text) for text in plain}
    events = "NO-human@1s#sihgt", "NO-human#light", "NO-human@25%#sight"
    said |= {text: refusal(realise, with_events(small, EVENTS), text) for text in events}
    patterns = "LATE-humna", "LATE-humna*", "late-human*", "late-human", "LATE-human@-1s", "EARLY-goal"
    said |= {f"select {pattern}": refusal(ids, matrix, pattern) for pattern in patterns}
    fault = matrices.Fault("person", "drop", {"share": 1.0}, place="human.yaml:5", places=PLACES, message=Detections)
    said |= {what: refusal(derive, a_matrix(replace(fault, **change))) for what, change in WRONG.items()}
    as_recorded(__file__, said)


def test_what_is_expected_of_a_mutant_is_found_again():
    known = matrices.Expected("nobody is there", (25.0,))
    matrix = a_matrix(matrices.Fault("person", "drop", {}, SHARES.magnitude, expected=known, message=Detections))
    sources = [source_of(matrix, mutant) for mutant in derive(matrix)]
    assert [fault.expects(rung) for fault, rung in sources] == [known, None]


def test_every_credible_and_control_cell_of_the_study_has_mutants_that_patch_their_seam(matrix: matrices.Matrix):
    derived = derive(matrix)
    assert {mutant.cell for mutant in derived} == {
        c.name for c in matrix if c.status is not matrices.CellStatus.NOT_MEANINGFUL
    }
    assert {mutant.id for mutant in defaults(matrix)} <= {mutant.id for mutant in derived}
    assert len({mutant.id for mutant in derived}) == len(derived)
    for mutant in derived:
        assert mutant.operator in OPERATORS
        assert realise(matrix, mutant.id) == mutant
        wire = wire_for(mutant, REFERENCE, contexts(mutant.id, "T0O0W0D0H0", 0, FACTS))
        assert set(getattr(wire, "counts")) == {mutant.seam}  # noqa: B009 - the baseline's wire has none


def ids(matrix: matrices.Matrix, *patterns: str) -> list[str]:
    return [mutant.id for mutant in select(patterns, matrix, derive(matrix))]


def test_a_bare_cell_name_is_its_default(matrix: matrices.Matrix):
    assert ids(matrix, "LATE-human") == ["LATE-human@3s"]
    assert ids(matrix, "LATE-human", "LATE-human@3s", "LATE-human@3.0s") == ["LATE-human@3s"]


def test_a_pattern_is_the_whole_ladder_with_its_phases(matrix: matrices.Matrix):
    assert ids(matrix, "LATE-human*") == ["LATE-human@0.5s", "LATE-human@1s", "LATE-human@3s", "LATE-human@5s"]
    assert ids(matrix, "UNINTENDED-collision@20s*") == [
        f"UNINTENDED-collision@20s{phase}"
        for phase in ("", "#5s", "#10s", "#15s", "#sight", "#obstacle", "#waypoint", "#person", "#recoil", "#mode")
    ]
    assert ids(matrix, "UNINTENDED-collision@20s#*s") == [f"UNINTENDED-collision@20s#{p}s" for p in (5, 10, 15)]


def test_a_pattern_of_cell_names_is_their_defaults(matrix: matrices.Matrix):
    human = [default_of(cell).id for cell in matrix if cell.parameter == "human" and cell.faults]
    assert len(human) > 5
    assert ids(matrix, "*-human") == human
    assert ids(matrix, "LATE-huma?") == ["LATE-human@3s"]


def test_the_unit_picks_the_operator_where_a_cell_has_two(matrix: matrices.Matrix):
    chosen = select(["NO-depth@3s", "NO-depth@50%"], matrix, derive(matrix))
    assert [mutant.operator for mutant in chosen] == ["outage", "drop"]


def test_a_magnitude_and_a_phase_off_the_catalogue_are_accepted(matrix: matrices.Matrix):
    assert ids(matrix, "LATE-human@2.5s", "UNINTENDED-collision#7s") == [
        "LATE-human@2.5s",
        "UNINTENDED-collision@20s#7s",
    ]


GUIDEWORDS = st.sampled_from(["NO", "MORE", "ASWELLAS", "UNINTENDED"])
PARAMETERS = st.sampled_from(["human", "velcmd", "speedlimit"])
MAGNITUDES = st.one_of(
    st.just(""),
    st.sampled_from(["y", "yaw", "infs", "100%", "2EV", "0.05radps", "5frames", "180deg", "1.5x", "0.8"]),
    st.builds(
        lambda n, unit: f"{n:g}{unit}", st.floats(1e-4, 1e4), st.sampled_from(["s", "ms", "x", "%", "m", "mps2"])
    ),
)
PHASES = st.floats(0.0, 1000.0).map(lambda s: float(f"{s:.4f}")).filter(lambda s: float(f"{s:g}") == s)
EVENT_NAMES = st.sampled_from(["sight", "waypoint", "mode", "s", "e5s", "flag_2"])
VALUES = st.one_of(st.booleans(), st.floats(allow_nan=False), st.sampled_from(["y", "per_axis"]))


@given(
    st.one_of(
        st.builds(matrices.Name, GUIDEWORDS, PARAMETERS, MAGNITUDES, PHASES),
        st.builds(matrices.Name, GUIDEWORDS, PARAMETERS, MAGNITUDES, event=EVENT_NAMES),
    )
)
def test_an_id_reads_back_as_it_was_written(name: matrices.Name):
    assert matrices.parse(str(name)) == name
    assert str(matrices.parse(str(name))) == str(name)
    assert "/" not in str(name)


@given(st.floats(1e-4, 1e4), st.sampled_from(["s", "ms", "x", "%", "m", "EV", "radps", "Hz", ""]))
def test_a_magnitude_splits_into_number_and_unit(number: float, unit: str):
    rung, found = matrices.split_magnitude(f"{number:g}{unit}")
    assert (f"{rung:g}", found) == (f"{number:g}", unit)


@cases("text")
def test_a_malformed_id_is_refused_with_the_form(text: str):
    with pytest.raises(InputError, match=r"must be of the form GUIDEWORD-parameter\[@magnitude\]\[#phase\]"):
        matrices.parse(text)


@given(st.dictionaries(st.sampled_from(["share", "delay_s", "field"]), VALUES))
def test_a_mutant_survives_json_and_pickling(arguments: dict[str, float | str | bool]):
    mutant = Mutant("NO-human@25%", "NO", "human", "25%", 5.0, "person", "drop", arguments)
    assert Mutant.from_json(json.loads(json.dumps(mutant.to_json()))) == mutant
    assert pickle.loads(pickle.dumps(mutant)) == mutant
    assert hash(mutant) == hash(pickle.loads(pickle.dumps(mutant)))


def test_the_event_of_a_mutant_survives_json_and_a_mutant_without_one_has_no_such_key():
    mutant = Mutant("NO-human@3s#sight", "NO", "human", "3s", 0.0, "person", "outage", {"burst_s": 3.0}, "sight")
    assert Mutant.from_json(json.loads(json.dumps(mutant.to_json()))) == mutant
    assert str(mutant.name) == mutant.id
    assert "event" not in PLACEBO.to_json()


def test_a_key_too_many_or_too_few_is_named():
    with pytest.raises(InputError, match="key 'colour' is unknown"):
        Mutant.from_json(PLACEBO.to_json() | {"colour": 1})
    with pytest.raises(InputError, match="key 'seam' is missing"):
        Mutant.from_json({k: v for k, v in PLACEBO.to_json().items() if k != "seam"})


STUDY = Path(__file__).parents[2]


def test_the_committed_catalogue_is_what_the_matrix_gives(matrix: matrices.Matrix):
    assert catalogue.check_catalogue(STUDY / "mutants", matrix) == derive(matrix)


def test_writing_twice_gives_the_same_bytes_and_reading_gives_the_mutants_back(matrix: matrices.Matrix, tmp_path: Path):
    derived = derive(matrix)
    first = catalogue.write_catalogue(tmp_path / "a", derived).read_bytes()
    assert catalogue.write_catalogue(tmp_path / "b", derived).read_bytes() == first
    assert catalogue.check_catalogue(tmp_path / "a", matrix) == derived


def stale(tmp_path: Path, matrix: matrices.Matrix, lines: list[str]) -> str:
    (tmp_path / catalogue.CATALOGUE).write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
    return refusal(catalogue.check_catalogue, tmp_path, matrix)


def test_a_stale_catalogue_is_refused_at_the_first_id_that_differs(matrix: matrices.Matrix, tmp_path: Path):
    lines = catalogue.catalogue_lines(derive(matrix))
    first, second = derive(matrix)[0].id, derive(matrix)[1].id
    place = f"{tmp_path / catalogue.CATALOGUE}"
    assert stale(tmp_path, matrix, lines[1:]).startswith(
        f"{place}:1: the catalogue is stale: {second!r} stands where the matrix gives {first!r}; write it with"
    )
    assert f"{derive(matrix)[-1].id!r} is missing" in stale(tmp_path, matrix, lines[:-1])
    assert f"{first!r} is not in the matrix" in stale(tmp_path, matrix, [*lines, lines[0]])
    changed = [lines[0].replace('"share": 0.25', '"share": 0.3'), *lines[1:]]
    assert f"{first!r} differs from the matrix" in stale(tmp_path, matrix, changed)


def test_a_missing_or_broken_catalogue_is_one_sentence_with_the_remedy(matrix: matrices.Matrix, tmp_path: Path):
    with pytest.raises(InputError, match="cannot be read: No such file or directory; write it with"):
        catalogue.check_catalogue(tmp_path, matrix)
    assert ":1: not a mutant in JSON; write it with" in stale(tmp_path, matrix, ["{"])
    (tmp_path / catalogue.CATALOGUE).write_text('{"id": "x"}\n', encoding="utf-8")
    with pytest.raises(InputError, match=r":1: key 'arguments' is missing"):
        catalogue.check_catalogue(tmp_path, matrix)


def test_a_folder_that_cannot_be_written_is_refused(matrix: matrices.Matrix, tmp_path: Path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="cannot be written"):
        catalogue.write_catalogue(tmp_path / "file", derive(matrix))
