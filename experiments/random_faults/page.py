"""The results of the experiment on random faults, from the flights of both arms."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from experiments.random_faults.arm import Arm, kill_sets, useful
from experiments.random_faults.compare import MEASURES, Counts, answer, p_of_kill_sets, redrawn
from experiments.random_faults.plan import FAULTS, FLIGHTS, POOL, REDRAWS, SITUATIONS, fisher
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.judge.outcome import BASELINE
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.mutants.operators import OPERATORS

Row = Sequence[object]
UNFINISHED = "Flights are missing, or baselines of the arms differ, so the rule is not decided."
COLUMNS = "Killed: situations with a kill, of those that test the fault; first: the earliest violation of a kill."
WORDS = {"detected": "detected", "trivial": "trivial", "useful": "useful", "kill_sets": "different sets of kills"}


def flown(hazop: Arm, random: Arm, faults: Mapping[str, Mutant], redraws: int = REDRAWS) -> str:
    """The section with the results.

    Args:
        hazop, random: the arms.
        faults: the mutants of both arms, by id, in the order of the page.
        redraws: how often the seeds are drawn again.
    """
    own, alike = _alike(hazop, random)
    complete = len(random.outcomes) == FLIGHTS and len(hazop.scores) == FAULTS and own == SITUATIONS * POOL
    comparable = random.states == hazop.states
    lines = [
        "",
        "## Flown",
        "",
        _told(random, alike, own, comparable=comparable),
        "",
        *(_decided(hazop, random, redraws) if complete and comparable else [UNFINISHED]),
        "",
        "### Arms",
        "",
        *_table(("", hazop.name, random.name), _counted((hazop, random))),
        "",
        _same(hazop, random, faults),
        "",
        "### By seam",
        "",
        "Faults / detected / useful.",
        "",
        *_table(("seam", hazop.name, random.name), _by_seam((hazop, random), faults)),
        "",
        "### Random faults",
        "",
        COLUMNS,
        "",
        *_table(
            ("id", "operator", "arguments", "stage", "verdict", "killed", "first [s]", "trivial"),
            _listed(random, faults),
        ),
    ]
    return "\n".join(lines) + "\n"


def _told(random: Arm, alike: int, own: int, *, comparable: bool) -> str:
    return (
        f"{len(random.outcomes):,} of {FLIGHTS:,} flights of random faults and baselines, {random.invalid} of them "
        f"invalid.  {alike} of {own} baselines have the digest of the published ones; the pairs of situation and "
        f"safety requirement {'all have the same' if comparable else 'do not all have the same'} state in both pools."
    )


def _alike(hazop: Arm, random: Arm) -> tuple[int, int]:
    """Number of valid baselines of the random arm, and of those whose digest is that of the other arm."""
    own, published = (arm.digests.get(BASELINE, {}) for arm in (random, hazop))
    return len(own), sum(published.get(draw) == digest for draw, digest in own.items())


def _decided(hazop: Arm, random: Arm, redraws: int) -> Iterator[str]:
    first, second = Counts.of(hazop.scores), Counts.of(random.scores)
    told, p = answer(first, second)
    yield (
        f"**Rule 1: {told.value}.**  Useful are {first.useful} of {first.faults} default mutants and {second.useful} "
        f"of {second.faults} random faults; p = {p:.2g}."
    )
    yield ""
    again = redrawn(hazop, random, redraws)
    ps = {
        "detected": fisher(first.detected, first.faults, second.detected, second.faults),
        "trivial": fisher(first.trivial, first.detected, second.trivial, second.detected),
        "useful": p,
        "kill_sets": p_of_kill_sets(hazop.scores, random.scores),
    }
    rows = [
        [
            WORDS[measure],
            *(
                f"{getattr(counts, measure)} ({_spread(spread)})"
                for counts, spread in zip((first, second), again[measure], strict=True)
            ),
            f"{ps[measure]:.2g}",
        ]
        for measure in MEASURES
    ]
    yield "In brackets: the middle nine tenths with the seeds drawn again.  p of *trivial* is of the detected."
    yield ""
    yield from _table(("faults", hazop.name, random.name, "p"), rows)


def _spread(numbers: Sequence[int]) -> str:
    least, most = np.quantile(numbers, (0.05, 0.95), method="nearest")
    return f"{least:g} to {most:g}"


def _counted(arms: Sequence[Arm]) -> Iterator[Row]:
    yield ("faults", *(len(arm.scores) for arm in arms))
    yield ("that change a sample", *(sum(s.infected for s in arm.scores) for arm in arms))
    yield ("that change a flight", *(sum(arm.acts(s.subject.id) for s in arm.scores) for arm in arms))
    yield ("put to the test", *(sum(s.tested for s in arm.scores) for arm in arms))
    yield ("detected", *(sum(s.detected for s in arm.scores) for arm in arms))
    yield ("of these trivial", *(sum(score.trivial for score in arm.scores) for arm in arms))
    yield ("- killed nearly wherever tested", *(sum(score.killed_broadly for score in arm.scores) for arm in arms))
    yield ("- killed right after take-off", *(sum(score.killed_early for score in arm.scores) for arm in arms))
    yield ("useful", *(sum(map(useful, arm.scores)) for arm in arms))
    yield ("different sets of kills", *(len(kill_sets(arm.scores)) for arm in arms))
    yield ("different vectors of digests", *(arm.behaviours for arm in arms))
    yield ("detected by operability", *(sum(s.operability.detected for s in arm.scores) for arm in arms))
    yield ("that make the stack raise an error", *(arm.stopped for arm in arms))


def _same(hazop: Arm, random: Arm, faults: Mapping[str, Mutant]) -> str:
    one, other = kill_sets(hazop.scores), kill_sets(random.scores)
    patched = {_patch(faults[score.subject.id]) for score in hazop.scores}
    again = sum(_patch(faults[score.subject.id]) in patched for score in random.scores)
    return (
        f"Sets of kills in both arms: {len(one & other)}; {len(one - other)} are of HAZOP alone, {len(other - one)} of "
        f"random faults alone.  {again} random faults are default mutants too."
    )


def _patch(mutant: Mutant) -> tuple[object, ...]:
    """What is patched in, with the operator's own value for each argument that the mutant leaves out."""
    own = {name: argument.default for name, argument in OPERATORS[mutant.operator].arguments.items()}
    return mutant.seam, mutant.operator, mutant.event, *sorted({**own, **mutant.arguments}.items())


def _by_seam(arms: Sequence[Arm], faults: Mapping[str, Mutant]) -> Iterator[Row]:
    seams = dict.fromkeys(faults[score.subject.id].seam for arm in arms for score in arm.scores)
    for seam in seams:
        own = [[s for s in arm.scores if faults[s.subject.id].seam == seam] for arm in arms]
        cells = (f"{len(part)} / {sum(s.detected for s in part)} / {sum(map(useful, part))}" for part in own)
        yield seam, *cells


def _listed(random: Arm, faults: Mapping[str, Mutant]) -> Iterator[Row]:
    scores = {score.subject.id: score for score in random.scores}
    return (_row(scores[id_], fault) for id_, fault in faults.items() if id_ in scores)


def _row(score: MutantScore, mutant: Mutant) -> Row:
    told = ", ".join(f"{name}={value}" for name, value in mutant.arguments.items() if value != "")
    first = f"{score.first.t_s:.1f}" if score.kills and score.first else ""
    reasons = {"everywhere": score.killed_broadly, "early": score.killed_early}
    rate = score.kill_rate
    return (
        mutant.id,
        mutant.operator,
        told,
        score.status.value.replace("_", " "),
        score.verdict.words,
        f"{rate.part}/{rate.whole}",
        first,
        ", ".join(name for name, holds in reasons.items() if holds),
    )


def _table(head: Sequence[str], rows: Iterable[Row]) -> Iterator[str]:
    for row in (head, ["---"] * len(head), *rows):
        yield f"| {' | '.join(map(str, row))} |"
