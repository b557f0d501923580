"""`scaloft-fi signals`: list the study's signals, without flying."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

from scaloft_fi.document import is_there
from scaloft_fi.judge.requirement import ANY, SIGHT_M, TRUTH, Cap, cap_of
from scaloft_fi.marks import Choices
from scaloft_fi.model import read
from scaloft_fi.outside.records import DERIVED, MappedSignal, load_record_map
from scaloft_fi.sim.happenings import HAPPENINGS
from scaloft_fi.sim.log import CLEARANCE_CAP_M, FAR_M, SIGNALS, Signal, belief_signals, clearance_name, truth_signals
from scaloft_fi.stack.declaration import Belief, unit_of
from scaloft_fi.study import Study
from scaloft_fi.verbs.listing import OWN, Entry, Listing, number_range, package_of
from scaloft_fi.verbs.names import signals
from scaloft_fi.verbs.options import GridOfStudy, Option, StudyFolder, verb
from scaloft_fi.views.output import Answer, Output


@dataclass(frozen=True)
class SignalFact:
    """What a signal can read.

    Attributes:
        example: a formula that uses it: `always( ... )` for a requirement, `eventually( ... )` for a predicate.
        unknown: what it reads where there is nothing to measure, in words; "" where there always is.
        least, most: between which numbers it is measured; None where nothing bounds it.
        elsewhere: the number that it reads there, where that is not in its range.
    """

    example: str
    unknown: str = ""
    least: float | None = None
    most: float | None = None
    elsewhere: float | None = None


EXAMPLES: Mapping[str, str] = {
    "elapsed_s": "always(elapsed_s >= 30 implies waypoints_left < 3)",
    "remaining_s": "always(remaining_s < 0.05 implies landed >= 0.5)",
    "x_m": "eventually(x_m < -1)",
    "y_m": "eventually(y_m > 5)",
    "z_m": "always(z_m <= 2.5)",
    **dict.fromkeys(("vx_mps", "vy_mps"), "always(abs(NAME) <= 2)"),
    "vz_mps": "always(vz_mps >= -1)",
    **dict.fromkeys(("qx", "qy", "qz", "qw"), "always(NAME >= 0)"),
    "yaw_rad": "eventually(yaw_rad > 1.5)",
    "speed_mps": "always(speed_mps / 0.8 <= 1)",
    "clearance_m": "always(clearance_m > 0)",
    "person_range_m": "always(person_range_m > 0.5)",
    "person_sight_m": "always(person_sight_m / 3 <= 1 implies speed_mps / 0.25 <= 1)",
    "waypoints_left": "always(landed >= 0.5 implies waypoints_left < 0.5)",
    "home_m": "always(landed >= 0.5 implies home_m <= 1)",
    "landed": "always(remaining_s < 0.05 implies landed >= 0.5)",
    "light": "always(light <= 0.05)",
    "obstacle_pixels": "eventually(obstacle_pixels >= 1)",
    "waypoint_wall_m": "eventually(waypoint_wall_m <= 0.5)",
    "mass_kg": "always(mass_kg > 1.7)",
    "takeoff_charge": "eventually(takeoff_charge < 0.3)",
    "haze_per_m": "eventually(haze_per_m >= 0.1)",
    **{f"wind_{axis}_mps": "eventually(abs(NAME) > 1)" for axis in "xyz"},
    **{f"drift_{axis}_m": "eventually(abs(NAME) > 0.2)" for axis in "xyz"},
}
"""A formula by name of the signal; `NAME` in it stands for that."""

UNKNOWN: Mapping[str, str] = {
    "person_range_m": f"{FAR_M:g} without a person",
    "person_sight_m": f"{FAR_M:g} without a person in sight within {SIGHT_M:g} m",
    "obstacle_pixels": "0 without an obstacle in view",
    "waypoint_wall_m": f"{FAR_M:g} farther than 0.5 m from every waypoint but home",
}
"""What signals read where there is nothing to measure."""

MEANINGS: Mapping[str, str] = {
    "person_sight_m": f"as person_range_m, where a straight line to the person is free; {FAR_M:g} otherwise",
    "haze_per_m": "extinction of light by dust; the distance of sight is 3 / haze_per_m",
    **{f"wind_{axis}_mps": "velocity of the air, world" for axis in "xyz"},
    **{f"drift_{axis}_m": "error of the localisation that happenings bring, world" for axis in "xyz"},
}
"""Of signals whose declarations do not say it, or only beside another signal."""


def fact_of(name: str) -> SignalFact | None:
    """The facts of a signal; None for one that a study or a plugin brings."""
    if name not in EXAMPLES:
        return None
    (least, _), *_, (far, most) = (spans := TRUTH.get(name, ANY))[0], spans[-1]
    apart = len(spans) > 1 and far == most == FAR_M
    if apart:
        most = spans[-2][1]
    bounds = {end: value for end, value in (("least", least), ("most", most)) if math.isfinite(value)}
    example = EXAMPLES[name].replace("NAME", name)
    return SignalFact(example, UNKNOWN.get(name, ""), elsewhere=FAR_M if apart else None, **bounds)


BOTH, REALISED, TO_ASK = "requirements, axes", "axes", "neither yet"
OVERVIEW = {"signal": "name", "unit": "unit", "range": "range", "meaning": "meaning", "used in": "used_in"}


@dataclass(frozen=True)
class ListedSignal(Entry):
    """A signal, sampled at 20 Hz.

    Attributes:
        unit: its unit; empty for a plain number.
        meaning: what it is.
        origin: where it comes from.
        used_in: which formulas may use it.
        range: what is measured, in words.
        least: least number that is measured; null: nothing bounds it.
        most: greatest number that is measured; null: nothing bounds it.
        beyond: what it reads beyond `most`.
        compare: the thresholds that formulas may have; empty for any.
        unknown: what it reads where there is nothing to measure; empty where there always is.
        recorded: where the record of a command has it; empty where our simulator flies.
        example: a formula that uses it.
    """

    unit: str
    meaning: str
    origin: str
    used_in: Annotated[str, Choices((BOTH, REALISED, TO_ASK))]
    range: str
    least: float | None
    most: float | None
    beyond: str
    compare: str
    unknown: str
    recorded: str
    example: str

    def sheet(self) -> Sequence[tuple[str, str]]:
        """The signal whole."""
        return [
            ("meaning", self.meaning),
            ("unit", self.unit or "none: a plain number"),
            ("range", self.range or "any number"),
            ("beyond", self.beyond),
            ("compare it", self.compare),
            ("nothing there", self.unknown),
            ("comes from", self.origin),
            ("used in", self.used_in),
            ("to have it", f"signals: [{self.name}] in sim/world.yaml" if self.used_in == TO_ASK else ""),
            ("in the record", self.recorded),
            ("example", self.example),
        ]


@dataclass(frozen=True)
class Signals:
    """The signals that requirements and the predicates of axes may use.

    Attributes:
        signals: the signals, those that the study could ask for last.
    """

    signals: tuple[ListedSignal, ...]


FORM = Output("signals", "1.0", Signals, rows="signals")


@dataclass(frozen=True)
class Found:
    """A signal and where it comes from.

    Attributes:
        signal: name, unit and meaning.
        origin: where it comes from, in words.
        used_in: `BOTH`, `REALISED` or `TO_ASK`.
        fact: what it can read.
    """

    name: str
    unit: str
    meaning: str
    origin: str
    used_in: str
    fact: SignalFact


def signal_list(study: Study) -> Listing[ListedSignal]:
    """Every signal that the study has, and the optional ones that it could ask for.

    Raises:
        InputError: a part of the study cannot be read.
    """
    caps, recorded = study.caps, _recorded(study)
    listed = tuple(_listed(found, cap_of(found.name, caps), recorded) for found in _found(study))
    formulas = "the formulas of requirements.yaml; the predicates `realised` of axes, false in a flight without it"
    notes = (
        f"used in: {formulas}; neither, before sim/world.yaml lists it under `signals`.",
        "`scaloft-fi signals NAME` shows one whole, with a formula.  All are sampled at 20 Hz.",
    )
    overview = OVERVIEW | ({"in the record": "recorded"} if recorded is not None else {})
    return Listing("signal", f"Signals: {len(listed)}", overview, listed, FORM, notes)


def _found(study: Study) -> Iterator[Found]:
    world, depth = study.grid.world(), study.grid.documents["sensors"].need("depth")
    pixels = depth.need("width").number() * depth.need("height").number()
    seen: set[str] = set()
    for signal in truth_signals(world.surfaces, ()):
        seen.add(signal.name)
        found = _truth(signal, world.bodies)
        yield replace(found, fact=replace(found.fact, most=pixels)) if signal.name == "obstacle_pixels" else found
    for name in world.signals:
        yield _declared(name, BOTH)
    for belief, signal in zip(study.stack.beliefs, belief_signals(study.stack.beliefs), strict=True):
        marks = belief.mark.values if belief.mark else ()
        meaning = signal.meaning + "".join(f", {place} {word}" for place, word in enumerate(marks))
        origin = f"belief of the stack {study.stack.name}"
        yield Found(signal.name, signal.unit, meaning, origin, BOTH, _belief_fact(belief))
    seen |= {*world.signals, *study.stack.belief_names}
    for name in study.signals:
        if name not in seen:
            fact = SignalFact(f"always({name} >= 0)")
            yield Found(name, unit_of(name), "as the command records it", "sim/record.yaml", BOTH, fact)
    yield from _passing(study, {*seen, *study.signals})
    for name in SIGNALS:
        if name not in world.signals:
            yield _declared(name, TO_ASK)


def _truth(signal: Signal, bodies: Mapping[str, Any]) -> Found:
    fact, origin = fact_of(signal.name), "ground truth"
    if fact is None:
        surface = signal.name.removeprefix("clearance_").removesuffix("_m")
        absent = f"{CLEARANCE_CAP_M:g} where it is not there, and for ground whose contact is excused"
        fact = SignalFact(f"always({signal.name} > 0)", absent, most=CLEARANCE_CAP_M)
        origin = f"ground truth, body {surface} of sim/world.yaml" if surface in bodies else f"ground truth, {surface}"
    return Found(signal.name, signal.unit, MEANINGS.get(signal.name, signal.meaning), origin, BOTH, fact)


def _declared(name: str, used_in: str) -> Found:
    declared = SIGNALS[name]
    package = package_of(declared.make)
    origin = "optional signal" if package == OWN else f"optional signal of the package {package}"
    most = declared.most if math.isfinite(declared.most) else None
    fact = fact_of(name) or SignalFact(f"eventually({name} >= {_threshold(most):g})", most=most)
    return Found(name, declared.unit, declared.meaning, origin, used_in, fact)


def _belief_fact(belief: Belief) -> SignalFact:
    """A belief that is 0 or 1 has a mark or is unknown as 0; else its example compares it with half of its range."""
    most = belief.most if math.isfinite(belief.most) else None
    unknown = "" if math.isnan(belief.unknown) else f"{belief.unknown:g} while the stack does not know it"
    if belief.mark is not None and belief.mark.values:
        last = len(belief.mark.values) - 1
        return SignalFact(f"always({belief.name} <= {last - 0.5:g})", unknown, 0.0, float(last))
    if not belief.unit and belief.unknown == 0.0:
        return SignalFact(f"once({belief.name} >= 0.5)", unknown, 0.0, most)
    return SignalFact(f"always({belief.name} <= {_threshold(most):g})", unknown, most=most)


def _threshold(most: float | None) -> float:
    return 1.0 if most is None else most / 2.0


def _passing(study: Study, known: set[str]) -> Iterator[Found]:
    """The signals that only flights with a happening, or with an optional body, record."""
    entries = study.grid.documents["world"].mapping().get("happenings")
    brought, moved = defaultdict[str, list[str]](list), defaultdict[str, list[str]](list)
    for happening, entry in (entries.mapping() if entries else {}).items():
        kind = HAPPENINGS[entry.need("kind").text()]
        for name in kind.signals:
            brought[name].append(happening)
        if body := read(kind.effect, entry, beside=entry.mapping()).moved:
            for axis in "xy":
                moved[f"{body}_{axis}_m"].append(happening)
    for name in dict.fromkeys(name for name in study.grid.passing_signals if name not in known):
        lacking = "not recorded in a flight without the {}, where `realised` is false"
        if by := moved.get(name) or brought.get(name):
            fact = fact_of(name) or SignalFact(f"eventually({name} > 1)")
            fact = replace(fact, unknown=lacking.format("happening"))
            noted = MEANINGS.get(name, "as the happening notes it")
            meaning = "position of the body, world" if name in moved else noted
            yield Found(name, unit_of(name), meaning, f"happening {', '.join(by)} of sim/world.yaml", REALISED, fact)
        else:
            body = name.removeprefix("clearance_").removesuffix("_m")
            example = f"eventually({clearance_name(body)} < 0.8)"
            fact = SignalFact(example, lacking.format("body"), most=CLEARANCE_CAP_M)
            yield Found(name, "m", f"hull to {body}, at most 1", f"ground truth, optional body {body}", REALISED, fact)


def _recorded(study: Study) -> Mapping[str, str] | None:
    """Where the record of a command has each signal; None where our simulator flies."""
    path = study.folder / "sim" / "record.yaml"
    if study.command is None or not is_there(path):
        return None

    def place(entry: MappedSignal) -> str:
        if entry.constant is not None:
            return f"always {entry.constant:g}"
        return f"column {entry.column}" if entry.column else f"{entry.topic}: {entry.field}"

    derived = dict.fromkeys([*DERIVED, "elapsed_s"], "follows from others")
    return derived | {name: place(entry) for name, entry in load_record_map(path).signals.items()}


def _listed(found: Found, cap: Cap | None, recorded: Mapping[str, str] | None) -> ListedSignal:
    fact, limit = found.fact, cap and f"{'at most' if cap.itself else 'less than'} {cap.most_m:g}"
    most = cap.most_m if cap else fact.most
    told = number_range(fact.least, most)
    return ListedSignal(
        name=found.name,
        unit=found.unit,
        meaning=found.meaning,
        origin=found.origin,
        used_in=found.used_in,
        range=told if fact.elsewhere is None else f"{told}, or {fact.elsewhere:g}",
        least=fact.least,
        most=most,
        beyond=cap.beyond.replace(" m ", " ", 1) if cap else "",
        compare=f"with {limit} {found.unit}".rstrip() if limit else "",
        unknown=fact.unknown,
        recorded="" if recorded is None else recorded.get(found.name, "not in the record"),
        example=fact.example,
    )


Names = Annotated[tuple[str, ...], Option("", "", metavar="[NAME]...", complete=signals)]


@verb("signals")
def signals_command(names: Names = (), *, study_folder: StudyFolder, grid: GridOfStudy) -> Answer:
    """List the signals that the study's requirements and the predicates of its axes may use.

    Without a NAME an overview.  Names, and patterns with *, ? or [, show these whole:  range, unit, source, a
    formula, and what the signal reads where there is nothing to measure.

    Examples:
        List all signals: `scaloft-fi signals`
        Show two of them whole: `scaloft-fi signals person_sight_m speed_mps`
        List what the grid `wide` adds, as CSV: `scaloft-fi signals --grid wide --format csv`
    """
    return signal_list(Study.open(study_folder, grid)).answer(names)
