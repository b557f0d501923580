"""Proposals of situations for one mutant: Optuna's tree-structured Parzen estimator (TPE) by ask and tell.

TPE (Bergstra et al., NeurIPS 2011) models where good and bad situations lie, handles axes that exist only with values
of other axes, and needs few trials.  It is told of situations that others proposed too.  A free axis is one parameter,
whose greatest values alone are off the benign value of the axis (`FreeAxis.drawn`): TPE so learns whether and where at
once.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count, islice
from typing import TYPE_CHECKING, Any, Protocol

from scaloft_fi.analysis.seeking import brief, situation_at
from scaloft_fi.errors import InputError
from scaloft_fi.sim.situation import DEVIATES, Situation
from scaloft_fi.streams import key_words

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid
    from scaloft_fi.study import Study


OPENING = 24
"""Situations that are flown for every mutant first; TPE proposes the others."""
EDGES = 1 / 2
"""Share of the numbers of the opening off their benign values that are not at an end of their range."""
TRIES = 10
"""Times that TPE is asked again for a situation that is impossible or was proposed before."""
IMPOSSIBLE = 3.0
"""What TPE is told of an impossible situation: farther from the fault than any other."""

Parameters = Mapping[str, Any]
Possible = Callable[[Situation], bool]
"""Whether a situation can be flown."""


def require_optuna() -> Any:
    """Import Optuna.

    Raises:
        InputError: it is not installed.
    """
    try:
        import optuna
    except ImportError as error:
        raise InputError("seek needs optuna: pip install 'scaloft-fi[seek]'") from error
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    return optuna


@dataclass(frozen=True)
class Proposal:
    """A proposed situation, and what it was made from."""

    situation: Situation
    parameters: Parameters


class Proposer(Protocol):
    """Proposes situations for one mutant."""

    @property
    def nearest(self) -> float:
        """The least distance so far."""

    def ask(self, count: int) -> list[Proposal]:
        """The next situations, none of them flown for the mutant before."""

    def tell(self, distances: Sequence[tuple[Proposal, float]]) -> None:
        """Tell how far situations are from showing the mutant, whoever proposed them."""


MakeProposer = Callable[["Grid", Possible, int, str], Proposer]
"""Makes the proposer of a mutant, from the grid, what can be flown, the seed of the search and the mutant's id."""
Opening = Callable[["Grid", int, Possible], Iterable[Proposal]]
"""Makes the situations that are flown for every mutant first, from the grid, the seed and what can be flown."""


def flyable(study: Study, situation: Situation) -> bool:
    """Whether a situation can be flown: its world is possible and its mission not too long."""
    try:
        study.scenario(situation)
    except InputError:
        return False
    return True


class Proposals:
    """The proposals for one mutant.

    Args:
        grid: the grid.
        possible: whether a situation can be flown.
        seed: seed of the search.
        mutant: id of the mutant, which names its stream of randomness.
    """

    def __init__(self, grid: Grid, possible: Possible, seed: int, mutant: str) -> None:
        self._optuna = optuna = require_optuna()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            sampler = optuna.samplers.TPESampler(
                n_startup_trials=OPENING,
                multivariate=True,
                group=True,
                constant_liar=True,
                seed=key_words("seek", seed, mutant)[0] % 2**32,
            )
        self._grid, self._possible = grid, possible
        self._study = optuna.create_study(sampler=sampler)
        self._asked: dict[Situation, Any] = {}
        self._known: dict[Situation, float] = {}

    def ask(self, count: int) -> list[Proposal]:
        """The next situations, none of them flown for the mutant before; fewer where TPE finds no more."""
        proposed: list[Proposal] = []
        for _ in range(count * TRIES):
            trial = self._study.ask()
            parameters = _suggest(trial, self._grid)
            situation = placed(self._grid, parameters)
            if situation is None or situation in self._asked or not self._possible(situation):
                self._study.tell(trial, IMPOSSIBLE)
            elif situation in self._known:
                self._study.tell(trial, self._known[situation])
            else:
                self._asked[situation] = trial
                proposed.append(Proposal(situation, parameters))
            if len(proposed) == count:
                break
        return proposed

    def tell(self, distances: Sequence[tuple[Proposal, float]]) -> None:
        """Tell how far situations are from showing the mutant, whoever proposed them."""
        for proposal, distance in distances:
            self._known[proposal.situation] = distance
            if (trial := self._asked.pop(proposal.situation, None)) is not None:
                self._study.tell(trial, distance)
            else:
                self._study.add_trial(self._trial(proposal.parameters, distance))

    def _trial(self, parameters: Parameters, distance: float) -> Any:
        choices = {axis.id: list(range(len(axis.values))) for axis in self._grid.axes}
        whole, part = self._optuna.distributions.CategoricalDistribution, self._optuna.distributions.FloatDistribution
        shapes = {name: whole(choices[name]) if name in choices else part(0.0, 1.0) for name in parameters}
        return self._optuna.create_trial(params=dict(parameters), distributions=shapes, value=distance)

    @property
    def nearest(self) -> float:
        """The least distance so far."""
        return min(self._known.values(), default=IMPOSSIBLE)

    @property
    def situations(self) -> tuple[Situation, ...]:
        """The situations so far, in the order in which they were told."""
        return tuple(self._known)


def opening(grid: Grid, seed: int, possible: Possible) -> Iterator[Proposal]:
    """The first proposals, the same for every mutant."""
    return islice(draws(grid, seed, possible), OPENING)


def draws(grid: Grid, seed: int, possible: Possible) -> Iterator[Proposal]:
    """Distinct situations of the grid that can be flown, drawn one after another, until no more are found.

    Half of the numbers off their benign values are at an end of their range: faults show at the edges of what the
    drone can do (boundary value analysis).
    """

    def share(number: int, axis: str, what: str) -> float:
        drawn = (key_words("seek", "opening", seed, number, axis, what)[0] >> 11) / 2**53  # exact, below 1
        if what == "level" or drawn < 1 - DEVIATES or share(number, axis, "level") < EDGES:
            return drawn
        return 1 - DEVIATES if drawn < 1 - DEVIATES / 2 else 1 - 2**-53

    known: set[Situation] = set()
    new = 0
    for number in count():
        parameters = at_shares(grid, partial(share, number))
        situation = placed(grid, parameters)
        if situation is not None and situation not in known and possible(situation):
            known.add(situation)
            new = number
            yield Proposal(situation, parameters)
        elif number - new > OPENING * TRIES:
            return


def at_shares(grid: Grid, share: Callable[[str, str], float]) -> Parameters:
    """The parameters at shares 0 <= share < 1 of an axis' `level` and `number`, as a random draw has them."""
    return _parameters(
        grid, lambda axis, count: int(share(axis, "level") * count), lambda name: share(name.rstrip("="), "number")
    )


def _suggest(trial: Any, grid: Grid) -> Parameters:
    """The parameters of a trial, each suggested where the situation has it."""

    def level(axis: str, count: int) -> int:
        chosen: int = trial.suggest_categorical(axis, list(range(count)))
        return chosen

    return _parameters(grid, level, lambda name: float(trial.suggest_float(name, 0.0, 1.0)))


def _parameters(grid: Grid, level: Callable[[str, int], int], number: Callable[[str], float]) -> Parameters:
    """The parameters of a situation: a level for each axis, and a number, 0 to 1, where the situation has one."""
    levels = {axis.id: level(axis.id, len(axis.values)) for axis in grid.axes}
    names = [f"{axis.id}=" for axis in grid.axes if axis.range]
    names += [axis.id for axis in grid.free if axis.goes_with(levels)]
    return {**levels, **{name: number(name) for name in names}}


def placed(grid: Grid, parameters: Parameters) -> Situation | None:
    """The situation of parameters; None where the grid has none.  A number is written as short as people say it."""
    levels = {axis.id: int(parameters[axis.id]) for axis in grid.axes}
    numbers: dict[str, float] = {}
    for axis in grid.axes:
        if axis.range:
            exact = axis.range.draw(levels[axis.id], min(parameters[f"{axis.id}="], 1 - 2**-53))
            short = brief(exact)
            numbers[axis.id] = short if axis.range.bin(short) == levels[axis.id] else exact
    for free in grid.free:
        drawn = free.drawn(parameters.get(free.id, 0.0))
        if drawn is not None:
            numbers[free.id] = short if free.holds(short := brief(drawn)) else drawn
    return situation_at(grid, levels, numbers)
