"""What each situation kills, what it alone kills, and what some situations kill together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from scaloft_fi.analysis.kills.kill_matrix import KillMatrix
from scaloft_fi.analysis.kills.subsumption import subsumption
from scaloft_fi.analysis.ratio import Ratio


@dataclass(frozen=True)
class SituationKills:
    """A situation as a test.

    Attributes:
        situation: key.
        killed: ids of the mutants it kills, as the scores count.
        tested: mutants that could have been killed there: it puts them to the test.
        alone: those of the killed that no other situation kills.
        minimal: minimal mutants it kills, of all: what it would score without redundant mutants.
    """

    situation: str
    killed: tuple[str, ...]
    tested: int
    alone: tuple[str, ...]
    minimal: Ratio


def situation_kills(matrix: KillMatrix) -> tuple[SituationKills, ...]:
    """Every situation flown, in the grid's order, those that kill nothing too."""
    graph = subsumption(matrix.kills)
    tested = Counter(entry.situation for row in matrix.mutants for entry in row.entries if entry.tested)
    return tuple(
        SituationKills(
            situation=key,
            killed=tuple(id_ for id_, keys in matrix.kills.items() if key in keys),
            tested=tested[key],
            alone=tuple(id_ for id_, keys in matrix.kills.items() if keys == {key}),
            minimal=graph.dominator_score([key]),
        )
        for key in matrix.flown
    )


@dataclass(frozen=True)
class ChosenKills:
    """What some situations kill together.

    Attributes:
        situations: keys.
        killed: mutants they kill, of those that any situation flown kills.
        dominator_score: the same among the minimal mutants: the dominator score (`Subsumption.dominator_score`).
        lost: ids of the mutants that only other situations kill.
    """

    situations: tuple[str, ...]
    killed: Ratio
    dominator_score: Ratio
    lost: tuple[str, ...]


def chosen_kills(matrix: KillMatrix, situations: Iterable[str]) -> ChosenKills:
    """What these situations kill together."""
    keys = tuple(dict.fromkeys(situations))
    lost = tuple(id_ for id_, kills in matrix.kills.items() if not kills & set(keys))
    whole = len(matrix.kills)
    return ChosenKills(keys, Ratio(whole - len(lost), whole), subsumption(matrix.kills).dominator_score(keys), lost)
