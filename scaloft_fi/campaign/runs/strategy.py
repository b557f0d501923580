r"""Strategies for choosing situations: all, at random, by draws, evenly spread, the first ones, a covering array.

A plugin declares a strategy with one decorated function, in a module that its entry point in the group
`scaloft_fi.plugins` names:

    @strategy("last", r"last:([1-9]\d*)", "last:N")
    def last(asked):
        return asked.each(asked.pool[-int(asked.match[1]):])
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from scaloft_fi.analysis.coverage import covering_array
from scaloft_fi.errors import InputError
from scaloft_fi.registry import Registry
from scaloft_fi.sim.situation import Situation
from scaloft_fi.streams import key_words

if TYPE_CHECKING:
    from scaloft_fi.judge.space import Space

OPTION = "--choose"
Draws = tuple[tuple[Situation, int], ...]
"""Situation and seed of each test case, in the order in which they are chosen."""


@dataclass(frozen=True)
class Asked:
    """The input of a strategy.

    Attributes:
        text: text of the user.
        match: match of the strategy's pattern with the text.
        pool: situations to choose from.
        seeds: seeds of the flights.
        seed: seed of the choice; a strategy draws from `streams.key_words("choice", name, seed, ...)`.
        space: the grid.
        place: where the text stands, for errors.
    """

    text: str
    match: re.Match[str]
    pool: tuple[Situation, ...]
    seeds: tuple[int, ...]
    seed: int
    space: Space
    place: str = OPTION

    def each(self, situations: Iterable[Situation]) -> Draws:
        """Every situation with every seed."""
        return tuple((situation, seed) for situation in situations for seed in self.seeds)

    def drawn(self, situation: Situation, *stream: object) -> Situation:
        """The situation with a number drawn from each range of its axes, inside the bin that it has there.

        Bins have equal probability, so a number in a random bin follows the distribution of the range.  A number that
        the situation has already is kept.  Most free axes stay at their benign values.

        Args:
            situation: a situation of the pool.
            stream: name of the stream of the numbers, beside the seed of the choice.
        """
        numbers = dict(situation.numbers)
        for axis, range_ in self.space.ranges:
            numbers.setdefault(axis, range_.draw(situation[axis], self._share(*stream, axis)))
        for axis, free in self.space.free:
            number = free.drawn(self._share(*stream, axis)) if free.goes_with(dict(situation.levels)) else None
            if number is not None and number != free.benign:
                numbers.setdefault(axis, number)
        numbers = {axis: numbers[axis] for axis, _ in self._numbered if axis in numbers}
        return Situation.of(dict(situation.levels), numbers)

    @property
    def _numbered(self) -> tuple[tuple[str, object], ...]:
        """The axes with numbers, in the order of keys."""
        return *self.space.ranges, *self.space.free

    def _share(self, *stream: object) -> float:
        return (key_words("choice", *stream[:-1], self.seed, stream[-1])[0] >> 11) / 2**53  # exact, below 1

    def error(self, allowed: str) -> InputError:
        """The error that refuses the text; `allowed` completes its message."""
        return InputError(f"{self.place}={self.text!r} {allowed}")


@dataclass(frozen=True)
class Strategy:
    """A declared strategy.

    Attributes:
        pattern: pattern of the texts that the strategy accepts.
        form: form of these texts, for messages.
        draw: returns the test cases; raises `Asked.error` where the text exceeds the grid.
    """

    pattern: re.Pattern[str]
    form: str
    draw: Callable[[Asked], Draws]


STRATEGIES = Registry[Strategy]("strategy")


def strategy(name: str, pattern: str, form: str) -> Callable[[Callable[[Asked], Draws]], Callable[[Asked], Draws]]:
    """Declare the decorated function as the strategy for texts that `pattern` matches in full.

    Raises:
        ValueError: the name is taken.
    """

    def declare(draw: Callable[[Asked], Draws]) -> Callable[[Asked], Draws]:
        STRATEGIES.declare(name, Strategy(re.compile(pattern), form, draw))
        return draw

    return declare


@strategy("all", "all", "all")
def every(asked: Asked) -> Draws:
    """Every situation."""
    return asked.each(asked.pool)


@strategy("random", r"random:([1-9]\d{0,8})", "random:N")
def at_random(asked: Asked) -> Draws:
    """Distinct situations at random; a larger choice includes every smaller one of the same seed."""
    ordered = sorted(asked.pool, key=lambda one: key_words("choice", "random", asked.seed, one.key))
    return asked.each(asked.drawn(one, "random", one.key) for one in ordered[: _count(asked)])


@strategy("draws", r"draws:([1-9]\d{0,8}|([1-9]\d?(?:\.\d+)?|100)%)", "draws:N, draws:P%")
def draws(asked: Asked) -> Draws:
    """Draws with replacement: N draws, or draws until P % of the pool was drawn; a repetition takes the next seed."""
    if len(asked.seeds) > 1:
        raise asked.error("gives each draw a seed of its own: --seeds must name one, the first")
    share = asked.match[2]
    target = math.ceil(Fraction(share) / 100 * len(asked.pool)) if share else None
    drawn = _until(asked.pool, asked.seed, target) if target else _numbered(asked.pool, asked.seed, int(asked.match[1]))
    numbered = (asked.drawn(one, "draws", number) for number, one in enumerate(drawn))
    return tuple(_with_seeds(numbered, asked.seeds[0]))


@strategy("sobol", r"sobol:([1-9]\d{0,8})", "sobol:N")
def sobol(asked: Asked) -> Draws:
    """Distinct situations spread evenly over all axes; a larger choice includes every smaller one of the same seed."""
    from scaloft_fi.campaign.runs.low_discrepancy import spread

    if not (asked.space.ranges or asked.space.free):
        _count(asked)
    drawn = next((one.key for one in asked.pool if one.numbers), None)
    if drawn is not None:
        raise asked.error(f"draws the numbers of ranges itself: --situation must name none, as in {drawn!r}")
    count = int(asked.match[1])
    found = spread(asked.pool, asked.space, count, asked.seed)
    if len(found) < count:
        raise asked.error(f"must ask for at most {len(found)}, the distinct situations that it finds")
    return asked.each(found)


@strategy("first", r"first:([1-9]\d{0,8})", "first:N")
def first(asked: Asked) -> Draws:
    """The first situations of the grid."""
    return asked.each(asked.pool[: _count(asked)])


@strategy("covering", r"([1-9]\d?)-way", "a covering array such as 2-way")
def covering(asked: Asked) -> Draws:
    """A small set of situations that covers every combination of the values of t axes."""
    strength = int(asked.match[1])
    if strength > len(asked.space.axes):
        raise asked.error(f"must be 1-way to {len(asked.space.axes)}-way, the number of axes")
    by_key = {situation.key: situation for situation in asked.pool}
    return asked.each(by_key[key] for key in covering_array(asked.space, tuple(by_key), strength, asked.seed))


def _count(asked: Asked) -> int:
    count = int(asked.match[1])
    if count > len(asked.pool):
        raise asked.error(f"must ask for at most {len(asked.pool)}, the situations to choose from")
    return count


def _numbered(pool: Sequence[Situation], seed: int, count: int) -> Iterator[Situation]:
    """The first draws of the endless sequence of this seed."""
    for number in range(count):
        # 64 bits modulo the pool: no situation is favoured by more than 1 in 10^13
        yield pool[key_words("choice", "draws", seed, number)[0] % len(pool)]


def _until(pool: Sequence[Situation], seed: int, target: int) -> Iterator[Situation]:
    """Draws until `target` distinct situations were drawn, the stopping condition of SCALOFT's loop."""
    seen = set()
    for situation in _numbered(pool, seed, 10**9):
        yield situation
        seen.add(situation)
        if len(seen) >= target:
            return


def _with_seeds(drawn: Iterator[Situation], first: int) -> Iterator[tuple[Situation, int]]:
    """Give each repetition of a situation the next seed, so that no flight occurs twice."""
    times: dict[Situation, int] = {}
    for situation in drawn:
        times[situation] = times.get(situation, -1) + 1
        yield situation, first + times[situation]
