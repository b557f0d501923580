from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace

import pytest
from builders import SIGNALS as READABLE
from hypothesis import given, settings
from hypothesis import strategies as st
from options import cases, usually
from refused import refusal

from scaloft_fi.errors import InputError
from scaloft_fi.judge import requirement as requirements
from scaloft_fi.judge.stl import CHANGES, Formula, FormulaError, parse, tokenize
from scaloft_fi.sim import observer
from scaloft_fi.sim.grid import load_grid
from scaloft_fi.sim.happenings import HAPPENINGS
from scaloft_fi.sim.log import SIGNALS, TRUTH_NAMES, clearance_name, signal_names
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.stack.reference.messages import BELIEFS

STUDY = Path(__file__).resolve().parents[2] / "sim" / "requirements.yaml"
REQUIREMENTS = {requirement.name: requirement for requirement in requirements.load_requirements(STUDY, READABLE)}

CALM = {
    "clearance_m": 1.0,
    "clearance_person_m": 1.0,
    "person_sight_m": 100.0,
    "speed_mps": 0.5,
    "told_person": 0.0,
    "told_range_m": 100.0,
    "remaining_s": 50.0,
    "landed": 0.0,
    "waypoints_left": 3.0,
    "home_m": 0.0,
}


def trace(samples: int, **signals: list[float]) -> dict[str, list[float]]:
    """A calm flight of some samples, 0.05 s apart, but for the signals given."""
    calm = {name: [CALM.get(name, 0.0)] * samples for name in READABLE}
    return calm | {"elapsed_s": [0.05 * i for i in range(samples)]} | signals


def said(
    name: str, cut_short: bool = False, **signals: list[float]
) -> tuple[requirements.Compliance, float | None, int]:
    samples = len(next(iter(signals.values())))
    reading = requirements.judge_signals(REQUIREMENTS[name], trace(samples, **signals), cut_short=cut_short).reading
    return reading.compliance, reading.violated_at_s and round(reading.violated_at_s, 2), reading.triggered


def test_the_study_has_the_four_requirements_of_their_kinds():
    assert {name: requirement.kind.value for name, requirement in REQUIREMENTS.items()} == {
        "SR1": "safety",
        "SR2": "safety",
        "SR2-literal": "reported",
        "OP1": "operability",
    }


NEAR, FAST = {"person_sight_m": [2.0] * 60}, {"speed_mps": [0.5] * 60}
COMES = {"person_sight_m": [100.0] * 60 + [2.9] * 60}
"""A person comes near at 3.0 s (sample 60): 2 s later, sample 100, the drone must be slow."""
VIOLATED, HELD, VACUOUS = (
    requirements.Compliance.VIOLATED,
    requirements.Compliance.HELD,
    requirements.Compliance.VACUOUS,
)
SAID: dict[str, tuple[str, dict[str, list[float]], tuple[requirements.Compliance, float | None, int]]] = {
    "a contact of a tenth of a centimetre": ("SR1", {"clearance_m": [0.4, 0.2, -0.001, 0.3]}, (VIOLATED, 0.1, 1)),
    "slow too late": ("SR2", COMES | {"speed_mps": [0.5] * 101 + [0.2] * 19}, (VIOLATED, 5.0, 1)),
    "slow in time": ("SR2", COMES | {"speed_mps": [0.5] * 100 + [0.2] * 20}, (HELD, None, 1)),
    "as fast as allowed": ("SR2", NEAR | {"speed_mps": [0.25] * 60}, (HELD, None, 1)),
    # at 2.00 s the trigger's own margin is 0, and a robustness of 0 is no violation
    "a hair too fast": ("SR2", NEAR | {"speed_mps": [0.251] * 60}, (VIOLATED, 2.05, 1)),
    "near from take-off": ("SR2", NEAR | {"speed_mps": [0.5] * 40 + [0.2] * 20}, (HELD, None, 1)),
    "out of sight in between": (
        "SR2",
        {"person_sight_m": [2.0] * 60 + [100.0] + [2.0] * 41, "speed_mps": [0.2] * 60 + [0.5] * 41 + [0.2]},
        (HELD, None, 2),
    ),
    "nobody near": ("SR2", {"person_sight_m": [3.5] * 80, "speed_mps": [0.5] * 80}, (VACUOUS, None, 0)),
    "a person touched at any speed": ("SR2", {"clearance_person_m": [1.0, 0.5, -0.001]}, (VIOLATED, 0.1, 0)),
    "a stack that is never told": ("SR2-literal", NEAR | FAST, (VACUOUS, None, 0)),
    "a stack that is told": (
        "SR2-literal",
        NEAR | FAST | {"told_person": [1.0] * 60, "told_range_m": [2.0] * 60},
        (VIOLATED, 2.05, 1),
    ),
    "landed with a waypoint left": ("OP1", {"landed": [0, 0, 1], "waypoints_left": [2, 1, 1]}, (VIOLATED, 0.1, 1)),
    "landed with none left": ("OP1", {"landed": [0, 0, 1], "waypoints_left": [2, 1, 0]}, (HELD, None, 1)),
    "the time is up": ("OP1", {"remaining_s": [0.1, 0.05, 0], "waypoints_left": [1, 1, 1]}, (VIOLATED, 0.1, 1)),
    "done when the time is up": ("OP1", {"remaining_s": [0.1, 0.05, 0], "waypoints_left": [1, 1, 0]}, (HELD, None, 1)),
}
"""By what happens: requirement, signals, and compliance, time of the violation and number of triggers."""


@pytest.mark.parametrize("what", SAID)
def test_a_requirement_of_the_study_says_what_happened(what: str):
    name, signals, expected = SAID[what]
    assert said(name, **signals) == expected


def test_sr1_holds_at_a_hair_and_its_robustness_is_the_least_clearance():
    judgement = requirements.judge_signals(
        REQUIREMENTS["SR1"], trace(3, clearance_m=[0.4, 0.001, 0.3]), cut_short=False
    )
    assert judgement.reading.compliance is requirements.Compliance.HELD
    assert judgement.reading.rho == 0.001
    assert judgement.sample is None


def test_sr2_robustness_is_a_share_of_the_limit():
    signals = trace(60, person_sight_m=[1.5] * 60, speed_mps=[0.2] * 60)
    assert requirements.judge_signals(REQUIREMENTS["SR2"], signals, cut_short=False).reading.rho == pytest.approx(0.2)


def test_what_was_not_violated_when_a_flight_is_cut_short_is_open():
    assert said("OP1", cut_short=True, waypoints_left=[3, 3])[0] is requirements.Compliance.OPEN
    assert (
        said("SR2", cut_short=True, person_sight_m=[2.0] * 60, speed_mps=[0.2] * 60)[0] is requirements.Compliance.OPEN
    )
    assert said("SR1", cut_short=True, clearance_m=[0.1, -0.001])[0] is requirements.Compliance.VIOLATED


def test_a_log_is_judged_by_its_signals_and_its_ending():
    log = SimpleNamespace(signals=trace(3), ending=SimpleNamespace(cut_short=True))
    assert requirements.judge(REQUIREMENTS["SR1"], log).open  # type: ignore[arg-type]


margins = st.lists(st.integers(-3, 3).map(float), min_size=1, max_size=30)


@given(margins)
def test_the_first_violation_is_the_end_of_the_shortest_violated_prefix(margin: list[float]):
    requirement = requirements.Requirement("R", requirements.Kind.SAFETY, "always(once[0:0.1](m >= 0))")
    times = [0.05 * i for i in range(len(margin))]

    def violated(length: int) -> bool:
        signals = {"elapsed_s": times[:length], "m": margin[:length]}
        return requirements.judge_signals(requirement, signals, cut_short=False).reading.rho < 0

    judgement = requirements.judge_signals(requirement, {"elapsed_s": times, "m": margin}, cut_short=False)
    shortest = next((length for length in range(1, len(margin) + 1) if violated(length)), None)
    assert judgement.sample == (None if shortest is None else shortest - 1)
    # once violated, a longer flight stays violated
    assert all(violated(length) for length in range(shortest or len(margin) + 1, len(margin) + 1))


@settings(deadline=None)
@given(margins)
def test_triggers_are_counted_as_episodes(margin: list[float]):
    on = "".join("1" if value >= 0 else "0" for value in margin)
    assert requirements.episodes(margin) == len([run for run in on.split("0") if run])


def written(folder: Path, text: str) -> Path:
    path = folder / "requirements.yaml"
    path.write_text(text, encoding="utf-8")
    return path


GOOD = "requirements:\n  R:\n    kind: safety\n    formula: always(clearance_m > 0)\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            GOOD.replace("clearance_m", "clearence_m"),
            ":4: formula names the unknown signal 'clearence_m'; did you mean",
        ),
        (GOOD.replace("safety", "safty"), ":3: kind='safty' is not known; did you mean 'safety'?"),
        (GOOD.replace("always(clearance_m > 0)", "clearance_m > 0"), ":4: formula must be always( ... )"),
        (GOOD.replace("> 0)", "> 0) and always(x_m > 0)"), ":4: formula must be always( ... )"),
        (GOOD.replace("clearance_m > 0", "eventually(x_m > 0)"), ":4: formula refers to the future with 'eventually'"),
        (GOOD.replace("> 0)", "> )"), ":4: formula is not a formula"),
        (GOOD + "    triger: x_m > 0\n", ":5: unknown key 'triger' in R; did you mean 'trigger'?"),
        (GOOD + "    trigger: x > 0\n", ":5: trigger names the unknown signal 'x'"),
        (GOOD + "    trigger: charge > 0\n", "the unknown signal 'charge'; `scaloft-fi signals` lists those there are"),
        (GOOD + "    trigger: historicaly > 0\n", "'historicaly'; did you mean 'historically'?"),
        (GOOD + "definitions:\n  x_m: y_m > 0\n", ":6: definition 'x_m' must not be named like a signal"),
        (GOOD + "definitions:\n  near: y > 0\n", ":6: near names the unknown signal 'y'"),
        (GOOD.replace("safety", "reported"), ":1: requirements must have at least one of kind safety"),
        (GOOD.replace("    formula: always(clearance_m > 0)\n", ""), "lacks the key 'formula'"),
        ("requirements: [\n", "not valid YAML"),
        (GOOD.replace("  R:", "  SR 2;x:"), ":2: name 'SR 2;x' must be letters, digits, -, _ and ."),
        (GOOD + "    unit: cm\n", ":5: unit='cm' must be m, the unit of clearance_m"),
    ],
)
def test_a_bad_file_is_one_sentence_with_its_line(tmp_path: Path, text: str, said: str):
    assert said in refusal(requirements.load_requirements, written(tmp_path, text), READABLE)


FAST_NEAR = GOOD + "    trigger: once(close)\n    unit: mps\ndefinitions:\n  close: abs(x_m - 3) <= 1\n"


def test_the_unit_of_a_requirement_is_that_of_its_signals_through_trigger_and_definitions(tmp_path: Path):
    written(tmp_path, FAST_NEAR.replace("clearance_m > 0", "trigger implies mean[0:1](y_m) < 2"))
    said = refusal(requirements.load_requirements, tmp_path / "requirements.yaml", READABLE)
    assert said.endswith("requirements.yaml:6: unit='mps' must be m, the unit of x_m")


@pytest.mark.parametrize(
    "formula",
    [
        "speed_mps < 1 and clearance_m > 0",
        "trigger implies speed_mps < 1",
        "x_m * 100 < 5",
        "sqrt(x_m) < 2",
        "landed < 1",
    ],
)
def test_a_robustness_of_several_units_or_of_none_that_is_known_may_have_any(tmp_path: Path, formula: str):
    path = written(tmp_path, FAST_NEAR.replace("clearance_m > 0", formula))
    (requirement,) = requirements.load_requirements(path, {*READABLE, "landed"})
    assert requirement.unit == "mps"


def test_definitions_may_build_on_those_above_them(tmp_path: Path):
    text = (
        GOOD.replace("clearance_m > 0", "far") + "definitions:\n  close: x_m < 1\n  far: not close\n  other: y_m > 0\n"
    )
    (requirement,) = requirements.load_requirements(written(tmp_path, text), READABLE)
    assert [name for name, _ in requirement.definitions] == ["close", "far"]
    signals = {name: [2.0, 0.5] for name in READABLE} | {"elapsed_s": [0.0, 0.05]}
    assert requirements.judge_signals(requirement, signals, cut_short=False).reading.rho == -0.5


@pytest.mark.parametrize("formula", ["always(1 / a > 0)", "always(sqrt(a - 1) >= 0)"])
def test_what_has_no_value_in_a_flight_is_one_sentence_that_names_the_requirement(formula: str):
    requirement = requirements.Requirement("A", requirements.Kind.SAFETY, formula)
    with pytest.raises(InputError, match=r"requirement A cannot be judged: .* at sample 1"):
        requirements.judge_signals(requirement, {"a": [1.0, 0.0], "elapsed_s": [0.0, 0.05]}, cut_short=False)


RANGES: requirements.Ranges = {
    "x_m": ((-6.0, 2.0),),
    "speed_mps": ((0.0, math.inf),),
    "light": ((0.0, 1.0),),
    "landed": ((0.0, 0.0), (1.0, 1.0)),
    "person_sight_m": ((0.0, 6.0), (100.0, 100.0)),
    "other": requirements.ANY,
}


def bounds(text: str) -> requirements.Spans:
    return requirements.bounds_of(Formula.parse(text, RANGES.keys()), RANGES)


@pytest.mark.parametrize(("text", "always"), [("once", False), ("historically", True)])
def test_a_window_that_begins_after_the_longest_flight_is_empty(text: str, always: bool):
    ranges = {**RANGES, "elapsed_s": ((0.0, 599.0),)}
    assert (
        requirements.verdict(requirements.bounds_of(Formula.parse(f"{text}[600:600](other > 3)", RANGES), ranges))
        is always
    )
    assert (
        requirements.verdict(requirements.bounds_of(Formula.parse(f"{text}[599:600](other > 3)", RANGES), ranges))
        is None
    )


@cases("text", "always")
def test_a_formula_that_no_flight_can_change_is_known(text: str, always: bool | None):
    assert requirements.verdict(bounds(text)) is always


def test_a_comparison_that_is_always_the_same_is_told_as_a_user_writes_it():
    formula = Formula.parse("(x_m / 2 < 30) and ((light > 0.5) or (abs(x_m) > 7))", RANGES.keys())
    assert list(requirements.constants(formula, RANGES)) == [("x_m / 2 < 30", True), ("abs(x_m) > 7", False)]


ATOMS = st.sampled_from(
    [
        "x_m < -1",
        "light > 0.5",
        "landed >= 0.5",
        "person_sight_m / 3 <= 1",
        "abs(x_m) * light >= 1",
        "x_m + light <= 2",
        "landed == light",
        "x_m - light - x_m > 0",
    ]
)
BEFORE = ("historically", "once", "historically[0:0.1]", "once[0.05:0.1]", "mean[0:0.1]", "always", "eventually")
"""What stands before a formula."""
FORMULAS = st.recursive(
    ATOMS.map("({})".format),
    lambda inner: st.one_of(
        st.builds("(not {})".format, inner),
        st.builds("({} {} {})".format, inner, st.sampled_from(["and", "or", "implies", "iff", "since"]), inner),
        st.builds("({}{})".format, st.sampled_from((*BEFORE, *CHANGES)), inner),
    ),
    max_leaves=4,
)


@st.composite
def samples(draw: st.DrawFn) -> dict[str, list[float]]:
    """Three samples of each signal within its range."""

    def column(spans: requirements.Spans) -> list[float]:
        within = st.one_of(*(st.floats(max(low, -1e3), min(high, 1e3)) for low, high in spans))
        return draw(st.lists(within, min_size=3, max_size=3))

    return {name: column(spans) for name, spans in RANGES.items()}


@given(text=FORMULAS, signals=samples())
def test_robustness_lies_within_the_bounds(text: str, signals: dict[str, list[float]]):
    formula = Formula.parse(text, RANGES.keys())
    spans = requirements.bounds_of(formula, RANGES)
    for value in formula.robustness(signals):
        inside = any(low - 1e-9 <= value <= high + 1e-9 for low, high in spans)
        assert inside or abs(value) == 1e9, (text, value, spans)  # 1e9 stands for an infinite robustness


@cases("text", "said")
def test_a_threshold_where_a_signal_is_not_measured_is_refused_with_the_cap_and_what_is_allowed(text: str, said: str):
    with pytest.raises(FormulaError) as caught:
        requirements.check_caps(text, REFERENCE.caps)
    assert said in str(caught.value)


@cases("text")
def test_a_threshold_within_what_is_measured_or_too_much_to_read_is_let_pass(text: str):
    requirements.check_caps(text)


def test_a_person_is_in_sight_as_far_as_the_observer_looks():
    assert requirements.SIGHT_M == observer.SIGHT_M


def test_every_clearance_has_a_cap_and_other_places_and_times_have_none():
    capped = {
        name for name in signal_names(("wall", "left_wall"), BELIEFS) if requirements.cap_of(name, REFERENCE.caps)
    }
    clearances = {"clearance_m", "clearance_wall_m", "clearance_left_wall_m"}
    assert capped == clearances | {"waypoint_wall_m", "person_sight_m", "person_range_m", "told_range_m"}


def _is_formula(text: str) -> bool:
    """Whether a text is a formula; some sums need brackets."""
    try:
        Formula.parse(text, ["a"])
    except FormulaError:
        return False
    return True


numbers = st.integers(-4, 9).map(lambda number: str(number or 5))
sums = st.recursive(
    st.one_of(numbers, st.just("a")),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(" ".join), inner.map(lambda text: f"({text})")
    ),
    max_leaves=6,
).filter(lambda text: _is_formula(f"{text} > a"))


@settings(max_examples=usually(25, release=300))
@given(sums, st.sampled_from(["<", "<=", ">", ">="]), sums)
def test_what_is_read_as_a_threshold_is_where_the_library_changes_its_mind(left: str, sign: str, right: str):
    text = f"always({left} {sign} {right})"
    for _, signal, _, threshold in requirements.comparisons(parse(tokenize(text))):
        assert signal == "a"
        at, below, above = Formula.parse(text.removeprefix("always"), ["a"]).robustness(
            {"a": [threshold, threshold - 1.0, threshold + 1.0]}
        )
        assert abs(at) < 1e-6
        assert below * above < 0


WORLD = load_grid(Path(__file__).parents[2] / "sim").world()


def test_every_range_is_of_a_signal_and_agrees_with_its_cap():
    assert requirements.TRUTH.keys() <= {*TRUTH_NAMES, *SIGNALS, *HAPPENINGS["dust"].signals}
    for name, spans in requirements.TRUTH.items():
        cap = requirements.cap_of(name)
        assert cap is None or spans[0][1] == cap.most_m, name


def test_bodies_beliefs_and_marks_have_their_ranges():
    ranges = requirements.ranges_of(WORLD, BELIEFS, [clearance_name("bar"), "mode", "nothing_known", "clearance_m"])
    assert ranges[clearance_name("bar")] == ranges["clearance_m"] == ((-float("inf"), 1.0),)
    assert ranges["mode"][0][0] == 0.0
    assert ranges["nothing_known"] == requirements.ANY


def test_the_rock_bounds_the_position_and_a_study_has_its_person():
    rock = requirements.within_rock(WORLD)
    assert -6.1 < rock["x_m"][0][0] < -5.4
    assert rock["z_m"] == (pytest.approx((0.0, 2.7)),)
    assert requirements.without(WORLD) == {}
