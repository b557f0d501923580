"""The choice of situations for a campaign that does not fly all of them, and its record in the store."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scaloft_fi.campaign.runs.strategy import OPTION, STRATEGIES, Asked, Draws
from scaloft_fi.campaign.store.flown_grid import remember_grid
from scaloft_fi.campaign.store.folder import STORE_NAME, promising, writable
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.errors import InputError
from scaloft_fi.sim.grid import ALL

if TYPE_CHECKING:
    from scaloft_fi.judge.space import Space
    from scaloft_fi.sim.situation import Situation
    from scaloft_fi.study import Study

NOTE = "choice"
"""Prefix of the names of choices in the campaign's store."""


def hint() -> str:
    """The accepted forms of `--choose`, in words."""
    forms = [strategy.form for strategy in STRATEGIES.values()]
    return f"{', '.join(forms[:-1])} or {forms[-1]}"


@dataclass(frozen=True)
class Choice:
    """The test cases of a run.

    Attributes:
        text, seed: values of `--choose` and `--choose-seed`.
        pool: number of situations to choose from.
        draws: situation and seed of each test case, in the order of the choice.
    """

    text: str
    seed: int
    pool: int
    draws: Draws

    @property
    def situations(self) -> tuple[Situation, ...]:
        """The situations, each once."""
        return tuple(dict.fromkeys(situation for situation, _ in self.draws))


def choose(
    text: str, pool: Sequence[Situation], seeds: Sequence[int], seed: int, space: Space, place: str = OPTION
) -> Choice:
    """Choose test cases; the same for the same arguments on every platform.

    Args:
        text: text for a declared strategy, such as `random:8`.
        pool: situations to choose from.
        seeds: seeds of the flights.
        seed: seed of the choice.
        space: the grid.
        place: where the text stands, for errors.

    Raises:
        InputError: no strategy accepts the text, or the strategy refuses it.
    """
    for strategy in STRATEGIES.values():
        match = strategy.pattern.fullmatch(text)
        if match:
            draws = strategy.draw(Asked(text, match, tuple(pool), tuple(seeds), seed, space, place))
            return Choice(text, seed, len(pool), tuple(draws))
    raise InputError(f"{place}={text!r} must be {hint()}")


def remember(study: Study, folder: Path, choice: Choice) -> None:
    """Record a choice, and the grid of which it is one, in the campaign's store; all situations are no choice.

    Raises:
        InputError: the store cannot be written.
    """
    if choice.text == ALL:
        return
    draws = [[situation.key, number] for situation, number in choice.draws]
    content = json.dumps({"choose": choice.text, "seed": choice.seed, "pool": choice.pool, "draws": draws})
    promising(folder)
    with Store(writable(folder) / STORE_NAME) as store:
        remember_grid(store, study)
        store.set_notes({f"{NOTE} {hashlib.sha256(content.encode()).hexdigest()[:16]}": content})


@dataclass(frozen=True)
class Remembered:
    """A recorded choice of a campaign.  draws: situation key and seed of each test case, in the order of the choice."""

    text: str
    seed: int
    pool: int
    draws: tuple[tuple[str, int], ...]


def remembered(store: Store) -> tuple[Remembered, ...]:
    """The recorded choices of a campaign.

    Raises:
        InputError: a record is no choice.
    """
    return tuple(sorted(store.records(NOTE, _read), key=lambda one: (one.text, one.seed)))


def _read(content: Any) -> Remembered:
    draws = tuple((str(key), int(number)) for key, number in content["draws"])
    return Remembered(str(content["choose"]), int(content["seed"]), int(content["pool"]), draws)
