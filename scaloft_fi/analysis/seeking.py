"""Search for a situation that shows a fault: how near a situation is, and whether fresh seeds confirm it.

**The test is the score's own** (`analysis/detection.py`), in the one situation, beside a pool of ten baselines.

**A search may try again.**  The j-th candidate of a mutant is tested at alpha * 2^-j, j = 1, 2, ...; these shares sum
to alpha, so the chance that a fault which does nothing is ever confirmed is at most alpha, however long the search.
A candidate spends its share before its pool is looked at.
The number of seeds follows from the share and the pool alone, before the mutant flies: as many as decide though one
flight does not violate.

**No knife edges.**  At least nine of ten baselines must hold the requirement with a robustness above the standard
deviation of the robustness over the baselines.

**The unmutated drone does its mission there.**  At least nine of ten baselines must hold each operability requirement,
and the value of each axis must come true in nine of ten, unless the search was told to take any situation.

A search picks its finds because of their flights, so those flights tell too good a tale of them.  A replication flies
each pair of find and mutant on seeds of its own, and asks of each the one requirement that the find names: does the
mutant violate it more often than the unmutated drone, by the exact test of the score (`detection.p_value`)?
Holm's adjustment over all pairs that are replicated together (Scand. J. Statist. 6, 1979) bounds by alpha the chance
that any pair without an effect holds.

Two violations are the same finding when their signatures are equal.
"""

from __future__ import annotations

import math
import re
from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby, repeat
from operator import attrgetter
from statistics import stdev
from typing import TYPE_CHECKING, Any

from scaloft_fi.analysis.detection import LEAST, Pool, Sample, Spending, adjusted, detect, holm, reaches
from scaloft_fi.errors import InputError, ScaloftError
from scaloft_fi.judge.outcome import Outcome, Violation
from scaloft_fi.judge.requirement import Kind, Requirement
from scaloft_fi.judge.stl import tokenize
from scaloft_fi.sim.grid import Again, Evidence, Find
from scaloft_fi.sim.log import SAMPLE_HZ
from scaloft_fi.sim.situation import Situation, cut
from scaloft_fi.stack.declaration import Claim, Instant

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid
    from scaloft_fi.sim.log import FlightLog
    from scaloft_fi.sim.world import World


ROOM = 0.02
"""Robustness that the search asks of the baseline [unit of the requirement: m, or share of the limit]."""
WORST = 1.5
"""Distance of a situation that says nothing: the fault changes no sample, or no requirement is put to the test."""
BEYOND = 2.5
"""Distance of a situation whose baseline violates by far; no distance is greater."""
UNFIT = 2.0
"""Distance of a situation where the unmutated drone does not do its mission."""
REJECTED = 0.5
"""Distance of a situation that shows something with the first seed only, or that fresh seeds do not confirm."""


def misses(baseline: Outcome) -> tuple[str, ...]:
    """What of its mission the unmutated drone does not do: operability requirements, and axes whose value is not met.

    A flight cut short before a requirement is judged does not hold it.
    """
    operability = (one for one in baseline.readings if one.kind is Kind.OPERABILITY)
    names = (f"requirement {one.requirement}" for one in operability if one.violated or one.open)
    return (*names, *(f"axis {axis}" for axis, met in baseline.realised if not met))


def distance(mutant: Outcome | None, baseline: Outcome | None, *, anyhow: bool = False) -> float:
    """How far a situation is from showing a fault; below 0 it shows the fault with this seed.

    Per safety requirement the share of the baseline's robustness that the mutant keeps: 1 where the fault does nothing,
    0 at the limit, negative beyond it.  A difference would favour requirements with large numbers, and the mutant's
    robustness alone situations that are hard for every drone.  Where the baseline has less than `ROOM` left, the
    distance is greater than `WORST` by what it lacks.  The least over the requirements counts.

    Args:
        mutant: outcome of the mutant; None without one.
        baseline: outcome of the baseline of the same situation and seed; None without one.
        anyhow: whether a situation counts where the baseline does not do its mission.
    """
    far = min((far for _, far in _distances(mutant, baseline)), default=WORST)
    return far if anyhow or _fits(baseline) else max(UNFIT, far)


def nearest(mutant: Outcome, baseline: Outcome) -> tuple[float, str]:
    """The distance and the requirement that has it; no requirement where none that is held with room tells anything."""
    told = [(far, name) for name, far in _distances(mutant, baseline) if far < WORST]
    return min(told, default=(WORST, ""))


def breaking(baseline: Outcome | None, requirement: str) -> float:
    """How far a situation is from breaking a requirement: the robustness that the unmutated drone has.

    `WORST` where the requirement is not put to the test.  Requirements are not compared: the robustness of one may be
    small wherever it is held, and would keep the search from the others.

    Args:
        baseline: outcome of the baseline; None without one.
        requirement: its name.
    """
    reading = baseline.reading(requirement) if baseline is not None and not baseline.invalid else None
    rho = reading.robustness if reading is not None and not reading.open else None
    return WORST if rho is None else max(-WORST, min(WORST, rho))


def shown_by(mutant: Outcome | None, baseline: Outcome | None, *, anyhow: bool = False) -> tuple[str, ...]:
    """The safety requirements by which the situation shows the fault with this seed."""
    counts = anyhow or _fits(baseline)
    return tuple(name for name, far in _distances(mutant, baseline) if counts and far < 0.0)


def is_of_use(baseline: Outcome | None, *, anyhow: bool = False) -> bool:
    """Whether the baseline does its mission and holds a requirement with room; else no mutant need fly beside it."""
    return (anyhow or _fits(baseline)) and any(far <= WORST for _, far in _distances(None, baseline))


def _fits(baseline: Outcome | None) -> bool:
    return baseline is None or not misses(baseline)


def _distances(mutant: Outcome | None, baseline: Outcome | None) -> Iterator[tuple[str, float]]:
    """The distance by each safety requirement that the baseline puts to the test."""
    for theirs in baseline.readings if baseline is not None and not baseline.invalid else ():
        held = theirs.robustness
        if theirs.kind is not Kind.SAFETY or theirs.open or held is None:
            continue
        left = _left(mutant, theirs.requirement)
        if held <= ROOM:
            yield theirs.requirement, min(BEYOND, WORST + ROOM - held)
        else:
            yield theirs.requirement, WORST if left is None else max(-WORST, min(WORST, left / held))


def _left(mutant: Outcome | None, requirement: str) -> float | None:
    """The robustness that a mutant leaves; None where it changes no sample or is not put to the test."""
    if mutant is None or mutant.invalid or not mutant.altered:
        return None
    reading = mutant.reading(requirement)
    return reading.robustness if reading else None


FEWEST, MOST = 3, 20
"""Seeds of the mutant, at least and at most."""
HOLD = 0.9
"""Share of the baselines that must hold the requirement with room to spare."""


@dataclass(frozen=True)
class Room:
    """How safely the baselines hold a requirement in a situation.

    Attributes:
        held: baselines whose robustness is above `spread`.
        of: baselines.
        margin: robustness that nine in ten of the baselines reach [unit of the requirement].
        spread: standard deviation of the robustness over the baselines.
    """

    held: int
    of: int
    margin: float
    spread: float

    @property
    def enough(self) -> bool:
        """Whether this is no knife edge."""
        return self.held >= HOLD * self.of


def share_of(alpha: float, candidate: int) -> float:
    """What of alpha the test of the j-th candidate may spend.

    >>> share_of(0.01, 1), share_of(0.01, 3)
    (0.005, 0.00125)
    """
    return float(alpha * 2.0**-candidate)


def room(requirement: str, baselines: Sequence[Outcome]) -> Room:
    """How safely the baselines hold a requirement."""
    readings = [reading for baseline in baselines if (reading := baseline.reading(requirement))]
    rhos = sorted(reading.rho for reading in readings)
    if len(rhos) < 2:
        return Room(0, len(baselines), 0.0, 0.0)
    spread = stdev(rhos)
    held = sum(not (one.violated or one.open) and one.rho > spread for one in readings)
    return Room(held, len(baselines), rhos[len(rhos) - round(HOLD * len(rhos))], spread)


def safely_held(pool: Pool, situation: str, names: Iterable[str], baselines: Sequence[Outcome]) -> tuple[str, ...]:
    """Those of the requirements that are steady in the pool of the situation, and no knife edge."""
    steady = pool.steady(situation, Kind.SAFETY)
    return tuple(name for name in names if name in steady and room(name, baselines).enough)


def does_mission(baselines: Sequence[Outcome]) -> bool:
    """Whether nine of ten baselines hold each operability requirement, and meet the value of each axis."""
    counted = [baseline for baseline in baselines if not baseline.invalid]
    missed = Counter(name for baseline in counted for name in misses(baseline))
    return all(len(counted) - times >= HOLD * len(counted) for times in missed.values())


def seeds_for(pool: Pool, situation: str, names: Sequence[str], alpha: float) -> int | None:
    """The number of seeds of a mutant that decide by one of the requirements though one flight does not violate.

    None where more than `MOST` would be needed.
    """
    for seeds in range(FEWEST, MOST + 1):
        for name in names:
            sample = Sample(situation, ((), *((name,) for _ in range(seeds - 1))), infected=True)
            if detect("", [sample], pool, Spending(alpha), Kind.SAFETY).detected:
                return seeds
    return None


def confirmed(
    flown: Sequence[Outcome], baselines: Sequence[Outcome], names: Sequence[str], candidate: int, alpha: float
) -> Evidence | None:
    """The evidence of the flights of a mutant in a situation; None where they do not confirm it.

    Args:
        flown: flights of the mutant in the situation, on seeds that no search flew.
        baselines: flights of the baseline there, ten or more.
        names: the requirements by which it may be confirmed.
        candidate: which candidate of the mutant the situation is, from 1.
        alpha: what p is compared with.
    """
    counted = [outcome for outcome in flown if not outcome.invalid]
    held = [baseline for baseline in baselines if not baseline.invalid]
    if len(counted) < FEWEST or len(held) < LEAST:
        return None
    sample = Sample.of(counted)
    told = detect(counted[0].mutant, [sample], Pool.of(held), Spending(alpha), Kind.SAFETY)
    by = [name for name in names if name in told.by and 2 * sample.count(name) > len(counted)]
    if not told.detected or not by:
        return None
    name = by[0]
    violations = [one for outcome in counted for one in outcome.violations if one.requirement == name]
    safely = room(name, held)
    return Evidence(
        requirement=name,
        candidate=candidate,
        p=told.p[name],
        alpha=alpha,
        violated=sample.count(name),
        flights=len(counted),
        struck=next((one.struck for one in violations if one.struck), ""),
        held=safely.held,
        baselines=safely.of,
        margin=safely.margin,
        spread=safely.spread,
        mission=sum(not misses(baseline) for baseline in held),
    )


@dataclass(frozen=True)
class Effort:
    """What the flights with the first seed of a search say of a mutant.

    Attributes:
        situations: in which it was flown, tries of shrinking included, where the baseline does its mission and holds a
            safety requirement with room.
        reached: those in which its seam carried a sample.
        infected: those in which it changed one.
        diverged: those in which the drone then flew otherwise than the baseline.
        showed: those in which it violates what the baseline holds with room.
        nearest: least share of the baseline's robustness that it kept; 1.5 where it changed no sample.
        requirement: of which requirement; empty where it changed no sample.
        situation: key of the situation where that was; empty where it changed no sample.
    """

    situations: int = 0
    reached: int = 0
    infected: int = 0
    diverged: int = 0
    showed: int = 0
    nearest: float = WORST
    requirement: str = ""
    situation: str = ""


def effort_of(flights: Iterable[Outcome], baselines: Mapping[str, Outcome], *, anyhow: bool = False) -> Effort:
    """The effort for a mutant.

    Args:
        flights: of the mutant, with the first seed of the search.
        baselines: with that seed, by situation.
        anyhow: whether situations count where the baseline does not do its mission.
    """
    valid = ((one, baselines.get(one.situation)) for one in flights if not one.invalid)
    pairs = [(one, clean) for one, clean in valid if clean is not None and is_of_use(clean, anyhow=anyhow)]
    far = [(*nearest(one, baseline), one.situation) for one, baseline in pairs]
    least = min((each for each in far if each[1]), default=(WORST, "", ""))
    return Effort(
        len(pairs),
        sum(one.carried > 0 for one, _ in pairs),
        sum(one.altered > 0 for one, _ in pairs),
        sum(one.altered > 0 and one.digest != baseline.digest for one, baseline in pairs),
        sum(distance < 0.0 for distance, _, _ in far),
        *least,
    )


SEEDS, POOL = 10, 30
"""Seeds of the mutant and of the baseline."""

Place = tuple[str, str]
"""A find and a mutant that it shows, by their names."""


@dataclass(frozen=True)
class Replica:
    """A pair of find and mutant, flown again.

    Attributes:
        find: name of the find.
        mutant: id of the mutant.
        requirement: the requirement that it is to violate.
        holds: whether the find holds for the mutant; else it leaves `sim/found.yaml`.  Null: flights are invalid, so
            nothing is decided and the find stays as it was.
        why: why it does not, or why nothing is decided; empty where it does.
        again: the evidence.
    """

    find: str
    mutant: str
    requirement: str
    holds: bool | None
    why: str
    again: Again


def replicas(
    finds: Sequence[Find],
    flown: Mapping[Place, Sequence[Outcome]],
    baselines: Mapping[str, Sequence[Outcome]],
    first: int,
    alpha: float,
    *,
    anyhow: bool = False,
) -> tuple[Replica, ...]:
    """What the flights say of each pair that was flown, in the order of the finds.

    Args:
        finds: the finds.
        flown: flights of the mutant by pair.
        baselines: flights of the baseline by key of the situation.
        first: first seed of all flights.
        alpha: the study's.
        anyhow: whether a pair may hold where the unmutated drone does not do its mission.
    """
    asked = ((find, mutant) for find in finds for mutant in find.shows if (find.name, mutant) in flown)
    claims = {(find.name, mutant): (find.situation, find.shows[mutant].requirement) for find, mutant in asked}
    whys, raw, broken = {}, {}, {}
    for place, (situation, requirement) in claims.items():
        pool = [one for one in baselines[situation] if not one.invalid]
        every = (*flown[place], *baselines[situation])
        broken[place] = sum(bool(one.invalid) for one in every)
        failed = f"{broken[place]} of {len(every)} flights are invalid" * bool(broken[place])
        whys[place] = failed or _unfit(pool, situation, requirement, anyhow=anyhow)
        raw[place] = 1.0 if whys[place] else _p(flown[place], pool, requirement)
    p = holm(raw)
    told = []
    for place, (situation, requirement) in claims.items():
        holds = not whys[place] and reaches(p[place], alpha)
        why = whys[place] or ("" if holds else f"p={p[place]:.2g} is above alpha={alpha:g}")
        again = _again(flown[place], baselines[situation], requirement, first, p[place])
        told.append(Replica(*place, requirement, None if broken[place] else holds, why, again))
    return tuple(told)


def _unfit(pool: Sequence[Outcome], situation: str, requirement: str, *, anyhow: bool) -> str:
    """Why no fault can be shown by a requirement in a situation; empty where one can."""
    if requirement not in Pool.of(pool).steady(situation, Kind.SAFETY):
        return f"the unmutated drone does not hold {requirement} steadily"
    return "" if anyhow or does_mission(pool) else "the unmutated drone does not do its mission"


def _p(flown: Sequence[Outcome], pool: Sequence[Outcome], requirement: str) -> float:
    counted = [one for one in flown if not one.invalid]
    infected = any(one.altered for one in counted)
    return adjusted([Sample.of(counted)], Pool.of(pool), [requirement])[requirement] if infected else 1.0


def _again(flown: Sequence[Outcome], baselines: Sequence[Outcome], requirement: str, first: int, p: float) -> Again:
    counted, held = ([one for one in flights if not one.invalid] for flights in (flown, baselines))
    violated = sum(any(own.requirement == requirement for own in one.violations) for one in counted)
    mission = sum(not misses(baseline) for baseline in held)
    return Again(first, p, violated, len(counted), room(requirement, held).held, len(held), mission)


HALVINGS = 3
"""Times that a number is halved towards its benign value."""

ALONE = 3
"""Changes that are tried alone in a round, where all of them together do not show the fault."""

Shows = Callable[[Sequence[Situation], bool], Sequence[bool]]
"""Whether each situation shows the fault: with the first seed of the search, or (True) with all of them."""
Numbers = dict[str, float]


def shrunk(situation: Situation, grid: Grid, shows: Shows) -> Situation:
    """The situation with axes reset and numbers halved towards benign values, as long as it shows the fault.

    In each round all axes are reset one by one; those that may be, are reset together where that still shows the
    fault, else one of the first alone.  Then numbers are halved in the same way.  At the end each axis is reset once
    more, all that may be tried alone, and each number that is left is rounded to one digit.

    Args:
        situation: shows the fault.
        grid: its grid.
        shows: asked for situations of the grid.
    """
    halved = partial(_renumbered, change=lambda number, benign: brief((number + benign) / 2))
    rounded = partial(_renumbered, change=rounded_away)
    stages: Sequence[tuple[Callable[[Situation, Grid], Iterable[Situation | None]], int | None, int | None]] = (
        (_resets, None, ALONE),
        (halved, HALVINGS, ALONE),
        (_resets, None, None),
        (rounded, None, None),
    )
    for changes, most, alone in stages:
        for _ in repeat(None) if most is None else range(most):
            simpler = _round(situation, changes(situation, grid), grid, shows, alone)
            if simpler == situation:
                break
            situation = simpler
    return situation


def _round(
    situation: Situation, changed: Iterable[Situation | None], grid: Grid, shows: Shows, alone: int | None
) -> Situation:
    """The situation after one round of changes."""
    tried = list(dict.fromkeys(one for one in changed if one is not None and one != situation))
    kept = [one for one, good in zip(tried, shows(tried, False) if tried else (), strict=True) if good]
    joint = _joined(situation, kept, grid)
    for one in dict.fromkeys([*([joint] if joint is not None else []), *kept[:alone]]):
        if all(shows([one], True)):
            return one
    return situation


def _joined(situation: Situation, changed: Sequence[Situation], grid: Grid) -> Situation | None:
    """The situation with the changes of all; None where they cannot be combined."""
    levels, numbers = dict(situation.levels), dict(situation.numbers)
    for one in changed:
        levels |= {axis: level for axis, level in one.levels if level != situation[axis]}
        theirs = dict(one.numbers)
        for axis, number in situation.numbers:
            if axis not in theirs:
                numbers.pop(axis, None)
            elif theirs[axis] != number and axis in numbers:
                numbers[axis] = theirs[axis]
    return situation_at(grid, levels, numbers) if changed else None


def _resets(situation: Situation, grid: Grid) -> Iterator[Situation | None]:
    """The situation with one axis at its benign value."""
    levels, numbers = dict(situation.levels), dict(situation.numbers)
    for axis in numbers:
        rest = {other: number for other, number in numbers.items() if other != axis}
        yield situation_at(grid, levels | ({axis: 0} if axis in levels else {}), rest)
    for axis, level in levels.items():
        if level and axis not in numbers:
            benign = levels | {axis: 0}
            going = {free.id for free in grid.free if free.goes_with(benign)} | levels.keys()
            yield situation_at(grid, benign, {other: n for other, n in numbers.items() if other in going})


def _renumbered(
    situation: Situation, grid: Grid, change: Callable[[float, float], float]
) -> Iterator[Situation | None]:
    """The situation with one number changed; `change` is given the number and its benign value."""
    levels, numbers = dict(situation.levels), dict(situation.numbers)
    benign = {axis.id: axis.benign for axis in grid.free}
    benign |= {axis.id: axis.range.benign for axis in grid.axes if axis.range}
    ranges = {axis.id: axis.range for axis in grid.axes if axis.range}
    for axis, number in numbers.items():
        other = change(number, benign[axis])
        bin_ = ranges[axis].bin(other) if axis in ranges else None
        if other not in (number, benign[axis]):
            yield situation_at(grid, levels | ({} if bin_ is None else {axis: bin_}), numbers | {axis: other})


def situation_at(grid: Grid, levels: dict[str, int], numbers: Numbers) -> Situation | None:
    """The situation of the grid with these values; None where it has none."""
    try:
        return grid.situation(grid.at(levels, numbers).key)
    except InputError:
        return None


def brief(number: float) -> float:
    """The number with two significant digits, as people say it.

    >>> brief(0.8713), brief(-12.34), brief(1.0)
    (0.87, -12.0, 1.0)
    """
    return cut(float(f"{number:.2g}"))


def rounded_away(number: float, benign: float) -> float:
    """The number with one significant digit, and no nearer to the benign value.

    >>> rounded_away(0.87, 0.5), rounded_away(0.33, 0.5), rounded_away(-0.0026, 0.0), rounded_away(5.0, 3.5)
    (0.9, 0.3, -0.003, 5.0)
    """
    if number == 0.0:
        return number
    unit = 10.0 ** math.floor(math.log10(abs(number)))
    steps = round(number / unit, 9)
    whole = math.ceil(steps) if number > benign else math.floor(steps)
    return cut(float(f"{whole * unit:.1g}"))


BEFORE_S = 1.0
"""How long before a violation a wrong belief counts [s]; in about that time the drone reacts and brakes."""

Samples = Mapping[str, Sequence[tuple[float, Any]]]
"""What a seam delivered: time [s] and sample, by seam."""


@dataclass(frozen=True)
class Signature:
    """What makes two violations the same finding.

    Attributes:
        requirement: the requirement.
        struck: the body struck at the violation; "" for none.
        leg: between which places of the route the drone flies, such as `corner to end`.
        near: the body that is struck, which tells the place; the nearer of the two where none is.
        belief: the stage whose belief was the most wrong; "" where none was wrong.
    """

    requirement: str
    struck: str
    leg: str
    near: str
    belief: str

    @property
    def name(self) -> str:
        """A name of letters, digits, _ and -.

        >>> Signature("SR1", "wall", "corner to end", "end", "").name
        'breaks-SR1-wall-corner_to_end-near_end-no_belief'
        >>> Signature("SR1", "bar", "corner to end", "bar", "obstacle map").name
        'breaks-SR1-bar-corner_to_end-obstacle_map'
        """
        near = () if self.near == self.struck else (f"near {self.near}",)
        parts = (self.requirement, self.struck or "nothing", self.leg, *near, self.belief or "no belief")
        return "-".join(("breaks", *(re.sub(r"\W+", "_", part, flags=re.ASCII) for part in parts)))


@dataclass(frozen=True)
class Breach:
    """A moment at which the unmutated drone begins to violate a safety requirement, or several.

    Attributes:
        signature: what makes it the same finding as another; of several requirements the study's first one.
        requirements: all of them.
        t_s: when [s from take-off].
        place: (3,) centre of the vehicle [m, world].
        error: how far the wrong belief was from the truth at most, in `unit`; 0 where none was wrong.
        unit: of the error.
    """

    signature: Signature
    requirements: tuple[str, ...]
    t_s: float
    place: tuple[float, float, float]
    error: float
    unit: str


def breaches(
    log: FlightLog,
    violations: Sequence[Violation],
    requirements: Sequence[Requirement],
    world: World,
    claims: Sequence[Claim],
    samples: Samples,
) -> tuple[Breach, ...]:
    """The moments at which a flight begins to violate safety requirements, the earliest first.

    Args:
        log: the flight, at least up to the last of the violations.
        violations: of the flight.
        requirements: of the study.
        world: of its situation.
        claims: of the stack.
        samples: what the seams of the claims delivered.

    Raises:
        ScaloftError: a claim raises, or its error is no finite number.
    """
    spoken_of = {requirement.name: _words(requirement) for requirement in requirements}
    told, by_time = [], attrgetter("t_s")
    for _, together in groupby(sorted(violations, key=by_time), key=by_time):
        first, *others = together  # who is struck, may be so against several requirements: that is one finding
        names = (first.requirement, *(one.requirement for one in others))
        words = frozenset().union(*(spoken_of[name] for name in names))
        matter = [claim for claim in claims if not claim.about or words.intersection(claim.about)]
        stage, error, unit = _most_wrong(log, first, matter, samples)
        signature = Signature(first.requirement, first.struck, *_where(log, first, world), stage)
        told.append(Breach(signature, names, first.t_s, (first.x, first.y, first.z), error, unit))
    return tuple(told)


def _words(requirement: Requirement) -> frozenset[str]:
    """The names in the formulas of a requirement."""
    texts = (requirement.text, requirement.trigger, *(text for _, text in requirement.definitions))
    return frozenset(word for text in texts for word in tokenize(text))


def _where(log: FlightLog, violation: Violation, world: World) -> tuple[str, str]:
    """The leg of the route by the ground truth, and what is near."""
    route = world.mission.route
    left = round(float(log.signals["waypoints_left"][log.at(violation.t_s)]))
    goal = max(0, min(len(route) - left, len(route) - 1))
    ends = ("home" if goal == 0 else route[goal - 1], route[goal])
    nearer = min(ends, key=lambda name: math.dist(world.waypoints[name][:2], (violation.x, violation.y)))
    return f"{ends[0]} to {ends[1]}", violation.struck if violation.struck in world.bodies else nearer


def _most_wrong(
    log: FlightLog, violation: Violation, claims: Sequence[Claim], samples: Samples
) -> tuple[str, float, str]:
    """The stage whose belief was the most wrong in the second before, as a multiple of what is allowed; error, unit.

    All is empty where no belief was wrong.
    """
    last = log.at(violation.t_s)
    place = (violation.x, violation.y, violation.z)
    worst, told = 1.0, ("", 0.0, "")
    for claim in claims:
        for sample in range(max(0, last - round(BEFORE_S * SAMPLE_HZ)), last):  # at a strike itself, estimates jump
            signals = {name: values[: sample + 1] for name, values in log.signals.items()}
            delivered = _delivered(samples.get(claim.seam, ()), float(signals["elapsed_s"][-1]))
            error = _error(claim, Instant(signals, delivered, place, violation.struck))
            if error > worst * claim.within:
                worst, told = error / claim.within, (claim.stage, error, claim.unit)
    return told


def _error(claim: Claim, now: Instant) -> float:
    try:
        error = float(claim.error(now))
    except Exception as problem:
        raise ScaloftError(f"claim {claim.stage!r}: {type(problem).__name__}: {problem}") from problem
    if not math.isfinite(error):
        raise ScaloftError(f"claim {claim.stage!r}: error={error} must be a finite number")
    return error


def _delivered(samples: Sequence[tuple[float, Any]], now_s: float) -> Any:
    """The newest sample that was delivered before a sample of the log, which is recorded before the stack runs."""
    count = bisect_left(samples, now_s, key=lambda one: one[0])
    return samples[count - 1][1] if count else None
