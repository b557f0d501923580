"""Fly the HAZOP of a firmware's own seams, as `scaloft-fi new --firmware` writes it, on Betaflight and PX4.

    python -m experiments.firmware_matrix [--output FILE]

Flies nothing: each kind of firmware has an archive in `results/published/firmware_matrix/`, with its study.
"""

from __future__ import annotations

from pathlib import Path

from experiments.four_autopilots import side_by_side
from experiments.pages import write
from scaloft_fi.mutants.catalogue import defaults
from scaloft_fi.study import Study

NAME = "firmware_matrix"
KINDS = ("betaflight", "px4")


def results(_study: Study, _jobs: int, folder: Path) -> str:
    """The section with the results: every fault on each firmware, then one beside the other."""
    studies = [Study.open(folder / NAME / kind) for kind in KINDS]
    ids = dict.fromkeys(mutant.id for study in reversed(studies) for mutant in defaults(study.matrix))
    return side_by_side(studies[0], folder / NAME, KINDS, [*ids])


if __name__ == "__main__":
    write(__doc__, NAME, results)
