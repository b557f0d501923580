"""The mutants of the experiment: of those that the paper's grid does not detect, a block for each parameter."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from experiments.published_outcomes import Row, outcomes
from experiments.wide import POOL, SEEDS
from scaloft_fi.analysis.score import score
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.mutants.catalogue import realise
from scaloft_fi.streams import key_words
from scaloft_fi.study import Study

FILE = Path(__file__).parent / "blocks.txt"
FEWEST, MOST = 2, 4
"""Mutants of a block."""
Block = tuple[str, ...]
"""Ids of the mutants of a block, which have one parameter and are sought together."""


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


def blocks_of(study: Study, ids: Iterable[str]) -> list[Block]:
    """The blocks, in the order of the ids: of each parameter with two of them or more, four at most, drawn by key."""
    parameters: dict[str, list[str]] = {}
    for id_ in ids:
        parameters.setdefault(realise(study.matrix, id_).parameter, []).append(id_)
    drawn = [
        sorted(own, key=lambda id_: key_words("search or chance", id_))[:MOST]
        for own in parameters.values()
        if len(own) >= FEWEST
    ]
    return [tuple(sorted(block, key=parameters[realise(study.matrix, block[0]).parameter].index)) for block in drawn]


def text_of(blocks: Iterable[Block]) -> str:
    """The file of the blocks, a line for each."""
    return "".join(f"{' '.join(block)}\n" for block in blocks)


def read_blocks() -> Sequence[Block]:
    """The blocks of the committed file."""
    return [tuple(line.split()) for line in FILE.read_text(encoding="utf-8").splitlines()]
