"""What to do next about a mutant that is not detected, by one rule for every screen."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.pool import State
from scaloft_fi.analysis.score import MutantScore, Score
from scaloft_fi.analysis.survivor import Background
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.status import Status
from scaloft_fi.study import NO_FINDS, KnownFinds
from scaloft_fi.views.score.finds import next_find


class Next(StrEnum):
    """What would make a survivor say something."""

    REPEAT = "repeat"
    FIND = "find"
    """The situation that a search found for it, which is to be flown."""
    POOL = "pool"
    """The baselines that are lacking to decide."""
    SEEDS = "seeds"
    SITUATION = "situation"
    MAGNITUDE = "magnitude"
    ORACLE = "oracle"
    OPERABILITY = "operability"
    """Nothing: an operability requirement detects it, and its cell puts no other at risk."""
    EXPECTED = "expected"
    """The study declares, with a reason, that it alters nothing in this grid."""


def next_steps(
    mutant: MutantScore, scored: Score, background: Background | None, finds: KnownFinds = NO_FINDS
) -> tuple[Next, ...]:
    """The step that the score of a mutant asks for; of two, its flights say which.

    Args:
        mutant: not detected.
        scored: of the campaign.
        background: what the study knows of the mutant; None where it knows nothing.
        finds: of the study.
    """
    known = background or Background("")
    stronger = Next.MAGNITUDE if known.stronger else Next.SITUATION
    if next_find(mutant, finds) is not None:
        return (Next.FIND,)
    if not mutant.flown:
        return (Next.REPEAT,)
    if known.expected and not mutant.infected:
        return (Next.EXPECTED,)
    if not mutant.infected:
        reached = any(result.reached for result in mutant.results)
        return (Next.MAGNITUDE if reached and infecting(scored, known.stronger) else Next.SITUATION,)
    if any(result.infected and result.situation in scored.lacking for result in mutant.results):
        return (Next.POOL,)
    if mutant.verdict is Verdict.NOT_TESTED:
        return (Next.SITUATION,)
    if mutant.status is Status.MASKED:
        return (stronger,)
    if mutant.verdict is Verdict.UNDECIDED:
        return (Next.SEEDS if mutant.safety.needed else Next.SITUATION,)
    safety = [name for name in known.at_risk if name in scored.pool.requirements(Kind.SAFETY)]
    if mutant.operability.detected:
        return (Next.ORACLE if safety else Next.OPERABILITY,)
    infected = [result.situation for result in mutant.results if result.infected]
    states = {scored.pool.states.get((key, name)) for key in infected for name in safety}
    return (Next.SITUATION,) if safety and State.STEADY not in states else (stronger, Next.ORACLE)


def infecting(scored: Score, ids: Sequence[str]) -> list[str]:
    """Those of some mutants that change a sample."""
    scores = {mutant.subject.id: mutant for mutant in scored.mutants}
    return [id_ for id_ in ids if id_ in scores and scores[id_].infected]


SHORT = {
    Next.REPEAT: "fly it again",
    Next.FIND: "fly its find",
    Next.POOL: "a baseline pool",
    Next.SITUATION: "another situation",
    Next.ORACLE: "an oracle",
    Next.OPERABILITY: "nothing: operability",
    Next.EXPECTED: "nothing: expected",
}
"""The steps in a few words; magnitude and seeds are named by `short_step`."""


def short_step(mutant: MutantScore, steps: Sequence[Next], background: Background | None) -> str:
    """The steps in a few words, for a row of a table."""
    words = dict(SHORT)
    words[Next.SEEDS] = f"--seeds {mutant.safety.needed}" + ", anew" * mutant.safety.anew
    words[Next.MAGNITUDE] = f"try {background.stronger[0]}" if background and background.stronger else ""
    return " or ".join(words[step] for step in steps)
