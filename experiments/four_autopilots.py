"""Fly drawn faults and the paper's three rows below four flight controls, and hold what they show side by side.

    python -m experiments.four_autopilots [--output FILE]

Flies nothing: each arm is an archive in `results/published/four_autopilots/`, with its study, the reference study with
the rotors of a quad X and, below the companion, a firmware; `autopilots.md` says which programs were flown.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from experiments.pages import blocks, table, write
from experiments.two_drones import counted, differences, figures
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.hazop.matrix import CellStatus, Matrix
from scaloft_fi.mutants.catalogue import default_of
from scaloft_fi.streams import generator
from scaloft_fi.study import Study
from scaloft_fi.verbs.campaigns import compared_by
from scaloft_fi.verbs.snapshot import snapshot

NAME = "four_autopilots"
PARAMETERS_DRAWN = frozenset(
    ("human", "collision", "depth", "exposure", "map", "goal", "pose", "velcmd", "waypoint", "speedlimit")
)
"""Of perception and navigation; the others are sensors of flight control, clocks and power."""
ROWS = ("LATE-human", "UNINTENDED-collision", "MORE-goal")
"""The paper's cells."""
DRAWN = 24


ARMS = ("ours", "again", "betaflight", "px4", "ardupilot")


def mutants(matrix: Matrix) -> list[str]:
    """The default mutants of the paper's cells, then those of the drawn cells in the order of the matrix."""
    credible = (cell for cell in matrix if cell.status is CellStatus.CREDIBLE)
    cells = {cell.name: cell for cell in credible if cell.parameter in PARAMETERS_DRAWN}
    others = [name for name in cells if name not in ROWS]
    chosen = generator(NAME, 0).choice(len(others), DRAWN, replace=False)
    return [default_of(cells[name]).id for name in (*ROWS, *(others[at] for at in sorted(chosen)))]


def results(study: Study, _jobs: int, folder: Path) -> str:
    """The section with the results: every fault below each flight control, then ours beside each of the others."""
    return side_by_side(study, folder / NAME, ARMS, mutants(study.matrix))


def side_by_side(study: Study, folder: Path, arms: Sequence[str], ids: Sequence[str]) -> str:
    """What each arm shows of each mutant, then the first arm beside each other one.

    Args:
        study: any study of the matrix.
        folder: of the archives, each named as its arm.
        arms: the arms, in order.
        ids: of the mutants, in the order of their rows.
    """
    scores, heads = {}, []
    for arm in arms:
        with snapshot(study, str(folder / arm)) as now:
            scores[arm] = {one.id: one for one in now.score.counted}
            heads.append(figures(now))
    rows = [(name, *(dict(one)[name] for one in heads)) for name, _ in heads[0]]
    parts: list[str | Iterator[str]] = ["## Flown", table(("", *arms), rows), "### Every fault"]
    parts += [
        "Verdict, and the situations where a violation of a safety requirement was seen, of those that test the fault.",
        table(("mutant", *arms), ((id_, *(_told(own.get(id_)) for own in scores.values())) for id_ in ids)),
    ]
    for arm in arms[1:]:
        told, _, _ = compared_by(study, str(folder / arms[0]), str(folder / arm), flights=False)
        sections = (one.replace("### ", "#### ", 1) for one in differences(told.scores, arms[0], arm, arms[0], arm))
        parts += [f"### {arms[0]} beside {arm}", counted(told.scores).replace("  ", " "), *sections]
    return blocks(*parts)


def _told(one: MutantScore | None) -> str:
    """The verdict on a mutant in an arm, and the situations where a violation was seen, of those that test it."""
    if one is None:
        return "-"
    if not one.tested:
        return one.verdict.words
    seen = f"{len(one.seen_in)}/{one.kill_rate.whole}"
    firm = ", firm" if one.firm else ""
    return f"**{one.verdict.words}**{firm}, {seen}" if one.detected else f"{one.verdict.words}, {seen}"


if __name__ == "__main__":
    write(__doc__, NAME, results)
