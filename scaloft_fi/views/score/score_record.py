"""The score as plain JSON values: what `score --format json` prints, below the version of its form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from scaloft_fi.analysis.coverage import Coverage
from scaloft_fi.analysis.detection import Detection, Noise
from scaloft_fi.analysis.roster import plain
from scaloft_fi.analysis.score import Group, Kill, Moment, MutantScore, Score
from scaloft_fi.analysis.survivor import Accepted, score_without
from scaloft_fi.hazop.matrix import class_of
from scaloft_fi.views.coverage.coverage_record import coverage_record
from scaloft_fi.views.score.accepted import accepted_values
from scaloft_fi.views.stale import NONE, Stale

RATIOS = ("exercised", "infected", "tested", "mutation_score", "firm", "operability")


def score_json(
    scored: Score,
    covered: Coverage,
    baselines: Sequence[tuple[str, Sequence[str]]],
    groups: Sequence[Group] = (),
    *,
    noise: Sequence[Noise] = (),
    looks: Sequence[Mapping[str, Any]] = (),
    unflown: Sequence[Mapping[str, Any]] = (),
    accepted: Sequence[Accepted] = (),
    stale: Stale = NONE,
) -> dict[str, Any]:
    """Plain JSON values of the form `SCORE`.

    Args:
        scored: the campaign's score.
        covered: its situation coverage.
        baselines: names what each situation's baseline violates in any flight.
        groups: the score part by part, where asked for.
        noise: of a stack that is not deterministic.
        looks: of a sequential run, as plain JSON values.
        unflown: what a run left out, as plain JSON values.
        accepted: the survivors that somebody accepted.
        stale: the flights of the campaign that no longer count.
    """
    return {
        "alpha": scored.alpha,
        "pooled": scored.pooled,
        "ratios": {name: plain(getattr(scored, name)) for name in RATIOS}
        | {"without_accepted": plain(score_without(scored, accepted))},
        "expected_false": scored.expected_false,
        "redraw": plain(scored.redraw),
        "composition": {
            "behaviours": plain(scored.behaviours),
            "without_kill": [mutant.subject.id for mutant in scored.without_kill],
            "trivial": [mutant.subject.id for mutant in scored.trivial],
            "without_effect": [
                {"id": mutant.subject.id, "acted": plain(mutant.acted)} for mutant in scored.without_effect
            ],
        },
        "mutants": [_mutant(mutant) for mutant in scored.mutants],
        "controls": [_mutant(mutant) for mutant in scored.controls],
        "pairs": plain(scored.pool.pairs.values()),
        "lacking": list(scored.lacking),
        "selected": list(scored.selected),
        "coverage": coverage_record(covered),
        "baseline": [{"situation": key, "violated": list(violated)} for key, violated in baselines],
        "groups": plain(groups),
        "noise": plain(noise),
        "looks": list(looks),
        "unflown": list(unflown),
        "accepted": accepted_values(accepted),
        **stale.values,
    }


def _mutant(mutant: MutantScore) -> dict[str, Any]:
    return {
        "id": mutant.subject.id,
        "guideword": mutant.subject.guideword,
        "parameter": mutant.subject.parameter,
        "magnitude": mutant.subject.magnitude,
        "severity": class_of(mutant.severity) or None,
        "status": mutant.status.value,
        "verdict": mutant.verdict.value,
        "firm": mutant.firmness.value if mutant.firmness else None,
        "p": dict(mutant.safety.p),
        "kill_rate": plain(mutant.kill_rate),
        "kill_rate_flown": plain(mutant.kill_rate_flown),
        "kills": [_kill(kill) for kill in mutant.kills],
        "requirements": plain(dict(mutant.requirements)),
        "first": _moment(mutant.first),
        "decided_at": _look(mutant.safety),
        "operability": {
            "verdict": mutant.operability.verdict.value,
            "p": dict(mutant.operability.p),
            "kills": [_kill(kill) for kill in mutant.operability_kills],
            "decided_at": _look(mutant.operability),
        },
    }


def _look(detection: Detection) -> dict[str, Any]:
    """The seeds that the verdict rests on, the share of alpha it is held against, the seeds that would decide it."""
    return {"seeds": detection.seeds, "alpha": detection.share, "needed": detection.needed, "anew": detection.anew}


def _kill(kill: Kill) -> dict[str, Any]:
    return {
        "situation": kill.situation,
        "requirement": kill.requirement,
        "violated": kill.violated,
        "flights": kill.flights,
    }


def _moment(moment: Moment | None) -> dict[str, Any] | None:
    if moment is None:
        return None
    return moment._asdict() | {"position": list(moment.position)}
