"""The mutants of the experiment: drawn from those that the paper's grid does not detect, and dealt into blocks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from published_outcomes import Row, outcomes
from wide import POOL, SEEDS

from scaloft_fi.analysis.scoring.score import score
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.streams import key_words
from scaloft_fi.study import Study

FILE = Path(__file__).parent / "blocks.txt"
BLOCKS, TOGETHER = 10, 4
"""Blocks, and mutants that are sought together in a block."""
Block = tuple[str, ...]
"""Ids of the mutants of a block, in the order of their turns."""


def survivors(study: Study, rows: Iterable[Row]) -> list[str]:
    """Defaults that no safety requirement detects in the published flights, with three seeds and a pool of ten.

    Args:
        study: the study.
        rows: the published flights.

    Returns:
        Ids in the order of the matrix.
    """
    defaults = set(study.roster.defaults.values())
    counted = [
        row
        for row in rows
        if (row["mutant"] == BASELINE and row["seed"] in POOL) or (row["mutant"] in defaults and row["seed"] in SEEDS)
    ]
    scored = score(outcomes(study, counted), study.roster, study.space).mutants
    detected = {mutant.subject.id for mutant in scored if mutant.detected}
    return [id_ for id_ in study.roster.defaults.values() if id_ not in detected]


def at_risk(study: Study, ids: Iterable[str]) -> list[str]:
    """Those of the defaults whose cell names a safety requirement."""
    safety = {requirement.name for requirement in study.requirements if requirement.kind is Kind.SAFETY}
    named = {study.roster.defaults.get(cell.name) for cell in study.matrix if safety & set(cell.requirements)}
    return [id_ for id_ in ids if id_ in named]


def deal(study: Study, ids: Iterable[str]) -> list[Block]:
    """The blocks: a systematic sample along the parameters, dealt in turn, so that a block has different parameters."""
    parameters = list(dict.fromkeys(cell.parameter for cell in study.matrix))
    parameter_of = {study.roster.defaults.get(cell.name): parameters.index(cell.parameter) for cell in study.matrix}
    ordered = sorted(ids, key=lambda id_: (parameter_of[id_], key_words("search or chance", id_)))
    start = key_words("search or chance", "start")[0] / 2**64
    wanted = BLOCKS * TOGETHER
    drawn = [ordered[int((start + number) * len(ordered) / wanted)] for number in range(wanted)]
    return [tuple(drawn[block::BLOCKS]) for block in range(BLOCKS)]


def text_of(blocks: Iterable[Block]) -> str:
    """The file of the blocks, a line for each."""
    return "".join(f"{' '.join(block)}\n" for block in blocks)


def read_blocks() -> Sequence[Block]:
    """The blocks of the committed file."""
    return [tuple(line.split()) for line in FILE.read_text(encoding="utf-8").splitlines()]
