"""Which situations a campaign flies, when not all: at random, by draws, a covering array, the first of the grid."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from scaloft_fi.analysis.situations.covering import covering_array
from scaloft_fi.campaign.store.folder import STORE_NAME, promising, writable
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.streams import key_words

if TYPE_CHECKING:
    from scaloft_fi.judge.space import Space
    from scaloft_fi.sim.situation import Situation

ALL = "all"
HINT = "all, random:N, draws:N, draws:P%, first:N, or a covering array such as 2-way"
NOTE = "choice"
"""What the names of a choice begin with in the campaign's store."""


@dataclass(frozen=True)
class Choice:
    """The test cases of a run.

    Attributes:
        text, seed: how they were chosen: the values of `--choose` and `--choose-seed`.
        pool: how many situations there were to choose from.
        draws: situation and seed of each test case, in the order in which they were chosen.
    """

    text: str
    seed: int
    pool: int
    draws: tuple[tuple[Situation, int], ...]

    @property
    def situations(self) -> tuple[Situation, ...]:
        """The situations, each once."""
        return tuple(dict.fromkeys(situation for situation, _ in self.draws))


def choose(text: str, pool: Sequence[Situation], seeds: Sequence[int], seed: int, space: Space) -> Choice:
    """Choose test cases; the same for the same arguments on every platform.

    Args:
        text: `all`; `random:N`, distinct ones; `draws:N` or `draws:P%`, with replacement, N of them or until P % of the
            pool was drawn; `first:N` in the grid's order; `T-way`, a covering array.
        pool: situations to choose from.
        seeds: of the flights.  A situation is flown with all of them; a draw takes one, the next at each repetition.
        seed: of the choice.
        space: the grid.

    Raises:
        InputError: the text is none of these, asks for more than there is, or names several seeds for draws.
    """
    if text == ALL:
        return _each(text, seed, pool, pool, seeds)
    if match := re.fullmatch(r"(random|first):([1-9]\d{0,8})", text):
        if int(match[2]) > len(pool):
            raise InputError(f"--choose={text!r} must ask for at most {len(pool)}, the situations to choose from")
        ordered = (
            pool if match[1] == "first" else sorted(pool, key=lambda one: key_words(NOTE, text[:6], seed, one.key))
        )
        return _each(text, seed, pool, ordered[: int(match[2])], seeds)
    if match := re.fullmatch(r"([1-9]\d?)-way", text):
        if int(match[1]) > len(space.axes):
            raise InputError(f"--choose={text!r} must be 1-way to {len(space.axes)}-way, the number of axes")
        by_key = {situation.key: situation for situation in pool}
        suite = covering_array(space, tuple(by_key), int(match[1]), seed)
        return _each(text, seed, pool, [by_key[key] for key in suite], seeds)
    if match := re.fullmatch(r"draws:([1-9]\d{0,8}|([1-9]\d?(?:\.\d+)?|100)%)", text):
        if len(seeds) > 1:
            raise InputError(f"--choose={text!r} gives each draw a seed of its own: --seeds must name one, the first")
        target = math.ceil(Fraction(match[2]) / 100 * len(pool)) if match[2] else None
        drawn = _until(pool, seed, target) if target else _numbered(pool, seed, int(match[1]))
        return Choice(text, seed, len(pool), tuple(_with_seeds(drawn, seeds[0])))
    raise InputError(f"--choose={text!r} must be {HINT}")


def _each(text: str, seed: int, pool: Sequence[Situation], chosen: Sequence[Situation], seeds: Sequence[int]) -> Choice:
    """Every situation with every seed."""
    return Choice(text, seed, len(pool), tuple((situation, number) for situation in chosen for number in seeds))


def _numbered(pool: Sequence[Situation], seed: int, count: int) -> Iterator[Situation]:
    """The first draws of the endless sequence of this seed."""
    for number in range(count):
        # 64 bits modulo the pool: no situation is favoured by more than 1 in 10^13
        yield pool[key_words(NOTE, "draws", seed, number)[0] % len(pool)]


def _until(pool: Sequence[Situation], seed: int, target: int) -> Iterator[Situation]:
    """Draws until `target` situations were drawn: the stopping condition of SCALOFT's loop."""
    seen = set()
    for situation in _numbered(pool, seed, 10**9):
        yield situation
        seen.add(situation)
        if len(seen) >= target:
            return


def _with_seeds(drawn: Iterator[Situation], first: int) -> Iterator[tuple[Situation, int]]:
    """Each repetition of a situation with its next seed, so that no draw is a flight that was flown before."""
    times: dict[Situation, int] = {}
    for situation in drawn:
        times[situation] = times.get(situation, -1) + 1
        yield situation, first + times[situation]


def remember(folder: Path, choice: Choice) -> None:
    """Keep in the campaign's store how its situations were chosen; that all are flown is no choice.

    Raises:
        InputError: the store cannot be written.
    """
    if choice.text == ALL:
        return
    draws = [[situation.key, number] for situation, number in choice.draws]
    content = json.dumps({"choose": choice.text, "seed": choice.seed, "pool": choice.pool, "draws": draws})
    promising(folder)
    with Store(writable(folder) / STORE_NAME) as store:
        store.set_notes({f"{NOTE} {hashlib.sha256(content.encode()).hexdigest()[:16]}": content})


@dataclass(frozen=True)
class Remembered:
    """A choice that was made for a campaign.  draws: situation key and seed of each, in the order chosen."""

    text: str
    seed: int
    pool: int
    draws: tuple[tuple[str, int], ...]


def remembered(store: Store) -> tuple[Remembered, ...]:
    """The choices of a campaign."""
    notes = [json.loads(text) for name, text in store.notes().items() if name.startswith(f"{NOTE} ")]
    return tuple(
        Remembered(one["choose"], one["seed"], one["pool"], tuple((key, number) for key, number in one["draws"]))
        for one in sorted(notes, key=lambda one: (one["choose"], one["seed"]))
    )
