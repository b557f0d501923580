"""Requirements that could show a fault which violates none: candidates over the log's signals, and the choice of one.

A candidate is a limit on a signal, on its mean in a window, on how long it stays beyond a level, or on how far it goes
within a second; for the whole flight, near a surface, or while or after a definition of the study holds.  Of each
candidate a flight has one number, its *reach*: the least limit that the flight would hold.  The choice is the
candidate, and the limit, that lies farthest beyond all that the unmutated drone reaches and that enough flights of the
mutant pass.  It is made on some seeds; whether it holds is for fresh ones to say (`campaign/runs/propose.py`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from scaloft_fi.judge.requirement import Kind, Requirement
from scaloft_fi.judge.stl import Formula, mean
from scaloft_fi.sim.log import SAMPLE_HZ, Signal

Array = NDArray[np.float64]

NOT_LIMITED = frozenset(("elapsed_s", "remaining_s"))
"""Signals with a unit on which a limit says nothing about the drone."""
NEAR_M = 0.5
"""Clearance within which the drone is near a surface [m]."""
WINDOWS_S, CHANGE_S = (1.0, 3.0), 1.0
"""Over what time a signal has its mean, for how long it stays beyond a level, and in what time it changes [s]."""
LEAST_SCALE = 0.05
"""Least spread that a margin is counted in, as a share of the limit, and in the signal's unit: no limit is finer."""
ESTIMATE = "est_"
"""How the name begins of a belief that estimates a signal of the ground truth."""


class Shape(Enum):
    """What of a term is limited: each sample, or in a window its mean, how long it stays beyond, or its change."""

    SAMPLE, MEAN, LASTING, CHANGE = range(4)


@dataclass(frozen=True)
class Condition:
    """When a candidate applies.  formula: "" for the whole flight; words: the beginning of its sentence."""

    formula: str
    words: str


@dataclass(frozen=True)
class Candidate:
    """A requirement without its limit.

    Attributes:
        term: what is limited, a term over signals.
        above: whether too large is bad; else too small.
        shape: what of the term.
        window_s: of the shape [s]; 0 for a limit on each sample.
        condition: when it applies.
        unit: of the limit.
    """

    term: str
    above: bool
    shape: Shape
    window_s: float
    condition: Condition
    unit: str

    @property
    def sign(self) -> float:
        """Of the limit in its reach: -1 where it limits from below."""
        return 1.0 if self.above or self.shape is Shape.CHANGE else -1.0

    def formula(self, limit: float) -> tuple[str, str]:
        """Trigger, "" for none, and formula with this limit.

        >>> always = Condition("", "")
        >>> Candidate("z_m", True, Shape.SAMPLE, 0.0, always, "m").formula(2.5)
        ('', 'always(z_m <= 2.5)')
        >>> Candidate("z_m", False, Shape.LASTING, 1.0, always, "m").formula(0.5)
        ('elapsed_s / 1 >= 1', 'always(trigger implies not historically[0:1](z_m <= 0.5))')
        >>> Candidate("z_m", True, Shape.MEAN, 3.0, always, "m").formula(0.5)
        ('elapsed_s / 3 >= 1', 'always(trigger implies (mean[0:3](z_m) <= 0.5))')
        """
        beyond, within = (">=", "<=") if self.above else ("<=", ">=")
        window = f"[0:{self.window_s:g}]"
        trigger, holds = self.condition.formula, f"{self.term} {within} {limit:g}"
        if self.shape in _WHOLE:
            since = f"elapsed_s / {self.window_s:g} >= 1"
            trigger = f"{since} and ({trigger})" if trigger else since
        if self.shape is Shape.MEAN:
            holds = f"mean{window}({self.term}) {within} {limit:g}"
        elif self.shape is Shape.LASTING:
            holds = f"not historically{window}({self.term} {beyond} {limit:g})"
        elif self.shape is Shape.CHANGE and self.above:
            holds = f"{self.term} - (historically{window}({self.term})) <= {limit:g}"
        elif self.shape is Shape.CHANGE:
            holds = f"(once{window}({self.term})) - {self.term} <= {limit:g}"
        inside = f"trigger implies {holds}" if self.shape is Shape.LASTING else f"trigger implies ({holds})"
        return trigger, f"always({inside})" if trigger else f"always({holds})"

    def sentence(self, limit: float) -> str:
        """The requirement in words."""
        words, unit = self.condition.words, f" {self.unit}".rstrip()
        way = "above" if self.above else "below"
        turned = "rise" if self.above else "fall"
        said = {
            Shape.SAMPLE: f"`{self.term}` is never {way} {limit:g}{unit}",
            Shape.MEAN: f"the mean of `{self.term}` over {self.window_s:g} s is never {way} {limit:g}{unit}",
            Shape.LASTING: f"`{self.term}` does not stay {way} {limit:g}{unit} for {self.window_s:g} s",
            Shape.CHANGE: f"`{self.term}` does not {turned} by more than {limit:g}{unit} within {self.window_s:g} s",
        }[self.shape]
        return f"{words}, {said}." if words else f"{said[0].upper()}{said[1:]}."


@dataclass(frozen=True, eq=False)
class Candidates:
    """All candidates of a study.

    Attributes:
        signals: of the log.
        definitions: of the study's requirements, name and formula, in order.
        surfaces: names of the surfaces with a clearance.
    """

    signals: tuple[Signal, ...]
    definitions: tuple[tuple[str, str], ...]
    surfaces: tuple[str, ...]

    @cached_property
    def terms(self) -> Mapping[str, str]:
        """The terms with their units: the signals that have one, and how far each estimate is from the truth."""
        units = {one.name: one.unit for one in self.signals if one.unit and one.name not in NOT_LIMITED}
        pairs = [(name, name.removeprefix(ESTIMATE)) for name in units if name.startswith(ESTIMATE)]
        return units | {f"abs({name} - {of})": units[of] for name, of in pairs if of in units}

    @cached_property
    def conditions(self) -> tuple[Condition, ...]:
        """The whole flight, then while and after each definition holds, and near each surface."""
        held = [
            one
            for name, _ in self.definitions
            for one in (Condition(name, f"While {name}"), Condition(f"once({name})", f"After the first {name}"))
        ]
        near = [
            Condition(f"clearance_{name}_m / {NEAR_M:g} <= 1", f"Within {NEAR_M:g} m of {name}")
            for name in self.surfaces
        ]
        return (Condition("", ""), *held, *near)

    @cached_property
    def listed(self) -> tuple[Candidate, ...]:
        """The candidates, in the order of a flight's reaches."""
        each = product(self.terms.items(), (True, False), _SHAPES, self.conditions)
        return tuple(Candidate(term, above, *shape, condition, unit) for (term, unit), above, shape, condition in each)

    def reaches(self, signals: Mapping[str, Array]) -> Array:
        """The reach of a flight in each candidate (C,); -inf where the candidate never applies.

        It grows with what is bad: of a candidate that limits from below it is the negative of the limit.

        Args:
            signals: of the log, (T,) each at 20 Hz.
        """
        known = {name: np.asarray(values, np.float64) for name, values in signals.items()}
        for name, formula in self.definitions:
            known[name] = np.asarray(Formula.parse(formula, known).robustness(known))
        elapsed_s = known["elapsed_s"]
        always = np.ones(len(elapsed_s), bool)
        applies = [
            np.asarray(Formula.parse(one.formula, known).robustness(known)) > 0 if one.formula else always
            for one in self.conditions
        ]
        found = []
        for term in self.terms:
            if (values := known.get(term)) is None:
                values = np.abs(np.subtract(*(known[name] for name in term[4:-1].split(" - "))))
            for sign in (1.0, -1.0):
                for shape, window_s in _SHAPES:
                    shaped = _shaped(sign * values, shape, round(window_s * SAMPLE_HZ))
                    late = elapsed_s > window_s if shape in _WHOLE else always
                    found += [shaped[mask & late].max(initial=-np.inf) for mask in applies]
        return np.array(found)


_WHOLE = (Shape.MEAN, Shape.LASTING)
"""The shapes that are limited only where the flight is as old as their window."""
_SHAPES = (
    (Shape.SAMPLE, 0.0),
    *((shape, window_s) for shape in _WHOLE for window_s in WINDOWS_S),
    (Shape.CHANGE, CHANGE_S),
)


def _shaped(values: Array, shape: Shape, last: int) -> Array:
    """What of the values at each sample and the `last` before it is limited (T,)."""
    if shape is Shape.SAMPLE:
        return values
    if shape is Shape.MEAN:
        return mean(values, last)
    least = _least(values, last + 1)
    return least if shape is Shape.LASTING else values - least


def _least(values: Array, count: int) -> Array:
    """The least of the last `count` values at each sample (T,), of fewer at the beginning."""
    padded = np.concatenate((np.full(count - 1, np.inf), values))
    least: Array = np.lib.stride_tricks.sliding_window_view(padded, count).min(axis=1)
    return least


@dataclass(frozen=True)
class Choice:
    """A candidate with its limit.

    Attributes:
        candidate: the candidate.
        limit: in its unit.
        margin: from what the unmutated drone reaches to the limit, in spreads of what it reaches, on the first seeds.
    """

    candidate: Candidate
    limit: float
    margin: float

    def requirement(self, name: str, definitions: tuple[tuple[str, str], ...]) -> Requirement:
        """The requirement, of a kind that decides nothing.

        Args:
            name: its name.
            definitions: of the study.
        """
        trigger, text = self.candidate.formula(self.limit)
        title = self.candidate.sentence(self.limit)
        used = tuple(one for one in definitions if one[0] in trigger)
        return Requirement(name, Kind.REPORTED, text, trigger, definitions if used else (), self.candidate.unit, title)


def choose(candidates: Sequence[Candidate], clean: Array, mutated: Array, least: int) -> Choice | None:
    """The candidate that separates the mutant from the unmutated drone with the widest margin; None where none does.

    The limit lies in the middle between what the unmutated drone reaches and what enough flights of the mutant pass:
    half of them, or else `least`.

    Args:
        candidates: the candidates, in number C.
        clean: (N, C) reaches of the unmutated drone.
        mutated: (M, C) reaches of the mutant.
        least: fewest flights of the mutant that have to pass the limit.
    """
    top = clean.max(axis=0)
    passed = -np.sort(-mutated, axis=0)
    with np.errstate(invalid="ignore"):
        spread = np.nan_to_num(np.where(np.isfinite(clean), clean, np.nan), nan=0.0).std(axis=0)
    for count in (max(least, len(mutated) // 2), least):
        if count > len(mutated):
            continue
        beyond = passed[count - 1]
        valid = np.isfinite(top) & np.isfinite(beyond) & (beyond > top)
        middle = np.where(valid, 0.5 * (np.where(valid, top, 0.0) + np.where(valid, beyond, 1.0)), 0.0)
        scale = np.maximum(spread, np.maximum(LEAST_SCALE * np.abs(middle), LEAST_SCALE))
        margins = np.where(valid, (middle - np.where(valid, top, 0.0)) / scale, 0.0)
        best = int(margins.argmax())
        if margins[best] > 0.0:
            candidate = candidates[best]
            reached = _rounded(float(top[best]), float(beyond[best]))
            return Choice(candidate, candidate.sign * reached, float(margins[best]))
    return None


def _rounded(low: float, high: float) -> float:
    """The number of fewest digits in the middle half of an interval.

    >>> _rounded(0.243, 0.391), _rounded(-2.0, -1.0)
    (0.3, -1.5)
    """
    middle, slack = 0.5 * (low + high), 0.25 * (high - low)
    for digits in range(-math.ceil(math.log10(max(abs(middle), slack))), 16):
        number = round(middle, digits)
        if abs(number - middle) <= slack:
            return number
    return middle
