"""Proposals of situations for one mutant: Optuna's tree-structured Parzen estimator (TPE) by ask and tell.

TPE (Bergstra et al., NeurIPS 2011) models where good and bad situations lie, handles axes that exist only with values
of other axes, and needs few trials.  The first proposals are the same for every mutant, so that the mutants share the
baselines there.  A free axis is one parameter, whose greatest values alone are off the benign value of the axis
(`FreeAxis.drawn`): TPE so learns whether and where at once.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count, islice
from typing import TYPE_CHECKING, Any

from scaloft_fi.analysis.seeking.shrink import brief
from scaloft_fi.errors import InputError
from scaloft_fi.sim.situation import Situation
from scaloft_fi.streams import key_words

if TYPE_CHECKING:
    from scaloft_fi.sim.grid import Grid
    from scaloft_fi.study import Study

GENERATION = 8
"""Situations that are proposed and flown before the next ones are proposed, whatever the number of processes."""
OPENING = 16
"""Proposals that are the same for every mutant; TPE proposes the others."""
TRIES = 10
"""Times that TPE is asked again for a situation that is impossible or was proposed before."""
IMPOSSIBLE = 3.0
"""What TPE is told of an impossible situation: farther from the fault than any other."""

Parameters = Mapping[str, Any]


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


@dataclass
class Proposal:
    """A proposed situation; `distance` is told to TPE when its generation is flown."""

    situation: Situation
    trial: Any
    distance: float


class Possible:
    """Whether a situation can be flown: its world is possible and its mission not too long."""

    def __init__(self, study: Study) -> None:
        self._study = study

    def __call__(self, situation: Situation) -> bool:
        """Whether it can."""
        try:
            self._study.scenario(situation)
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
        further: drawn situations, which take half of each generation after the opening; None for none.
    """

    def __init__(
        self,
        grid: Grid,
        possible: Callable[[Situation], bool],
        seed: int,
        mutant: str,
        further: Iterator[Parameters] | None = None,
    ) -> None:
        optuna = require_optuna()
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
        self._known: dict[Situation, float] = {}
        self._further = further or iter(())
        for parameters in opening(grid, seed):
            self._study.enqueue_trial(dict(parameters))

    def ask(self) -> list[Proposal]:
        """The next generation: distinct situations that were not proposed before; fewer where TPE finds no more."""
        proposed: list[Proposal] = []
        if not any(trial.state.name == "WAITING" for trial in self._study.get_trials(deepcopy=False)):
            for parameters in islice(self._further, GENERATION // 2):
                self._study.enqueue_trial(dict(parameters))
        for _ in range(GENERATION * TRIES):
            trial = self._study.ask()
            situation = placed(self._grid, _suggest(trial, self._grid))
            if situation is None or not self._possible(situation):
                self._study.tell(trial, IMPOSSIBLE)
            elif situation in self._known:
                self._study.tell(trial, self._known[situation])
            elif any(situation == before.situation for before in proposed):
                self._study.tell(trial, IMPOSSIBLE)
            else:
                proposed.append(Proposal(situation, trial, IMPOSSIBLE))
            if len(proposed) == GENERATION:
                break
        return proposed

    def tell(self, proposed: Sequence[Proposal]) -> None:
        """Tell the distances of a generation, in its order."""
        for proposal in proposed:
            self._known[proposal.situation] = proposal.distance
            self._study.tell(proposal.trial, proposal.distance)

    @property
    def nearest(self) -> float:
        """The least distance so far."""
        return min(self._known.values(), default=IMPOSSIBLE)

    @property
    def situations(self) -> tuple[Situation, ...]:
        """The situations so far, in the order in which they were told."""
        return tuple(self._known)

    @property
    def count(self) -> int:
        """Situations flown so far."""
        return len(self._known)


def opening(grid: Grid, seed: int) -> Iterator[Parameters]:
    """The parameters of the first proposals, the same for every mutant."""
    return islice(draws(grid, seed), OPENING)


def draws(grid: Grid, seed: int) -> Iterator[Parameters]:
    """The parameters of distinct situations of the grid, drawn one after another; they end where no more are found."""

    def share(number: int, axis: str, what: str) -> float:
        return (key_words("seek", "opening", seed, number, axis, what)[0] >> 11) / 2**53  # exact, below 1

    known: set[Situation | None] = {None}
    new = 0
    for number in count():
        levels = {axis.id: int(share(number, axis.id, "level") * len(axis.values)) for axis in grid.axes}
        chosen: dict[str, Any] = dict(levels)
        chosen |= {f"{axis.id}=": share(number, axis.id, "number") for axis in grid.axes if axis.range}
        chosen |= {axis.id: share(number, axis.id, "number") for axis in grid.free if axis.goes_with(levels)}
        if (situation := placed(grid, chosen)) not in known:
            known.add(situation)
            new = number
            yield chosen
        elif number - new > OPENING * TRIES:
            return


def _suggest(trial: Any, grid: Grid) -> Parameters:
    """The parameters of a trial, each suggested where the situation has it."""
    chosen: dict[str, Any] = {
        axis.id: trial.suggest_categorical(axis.id, list(range(len(axis.values)))) for axis in grid.axes
    }
    levels = dict(chosen)
    chosen |= {f"{axis.id}=": trial.suggest_float(f"{axis.id}=", 0.0, 1.0) for axis in grid.axes if axis.range}
    chosen |= {axis.id: trial.suggest_float(axis.id, 0.0, 1.0) for axis in grid.free if axis.goes_with(levels)}
    return chosen


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
    try:
        return grid.situation(grid.at(levels, numbers).key)
    except InputError:
        return None
