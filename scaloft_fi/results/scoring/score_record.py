"""The score as plain JSON values: what `score --format json` prints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from scaloft_fi.results.scoring.decision import Decision
from scaloft_fi.results.scoring.ratio import ratio_json, share_json
from scaloft_fi.results.scoring.redraw import NO_PAIRS
from scaloft_fi.results.scoring.score import MutantScore, Result, Score
from scaloft_fi.results.situations.coverage import Coverage, coverage_json


def score_json(scored: Score, covered: Coverage, baselines: Sequence[tuple[str, Sequence[str]]]) -> dict[str, Any]:
    """The score as plain JSON values; `baselines` names what each situation's baseline violates."""
    ratios = ("exercised", "infected", "mutation_score", "strict_score")
    return {
        "ratios": {name: ratio_json(getattr(scored, name)) for name in ratios},
        "mutants": [_mutant(mutant) for mutant in scored.mutants],
        "coverage": _coverage(covered),
        "baseline": [{"situation": key, "violated": list(violated)} for key, violated in baselines],
        "decided_score": ratio_json(scored.decided_score),
        "operability": ratio_json(scored.operability),
        "redraw": _redraw(scored),
    }


def _coverage(covered: Coverage) -> dict[str, Any]:
    """`t_way` with parts and wholes alone, `complete` with its (p, t)-completeness."""
    told = coverage_json(covered)
    complete = {strength: found["complete"] for strength, found in told["t_way"].items()}
    t_way = {str(strength): share_json(ratio) for strength, ratio in covered.t_way}
    return told | {"t_way": t_way, "complete": complete}


def _mutant(mutant: MutantScore) -> dict[str, Any]:
    return {
        "id": mutant.subject.id,
        "guideword": mutant.subject.guideword,
        "parameter": mutant.subject.parameter,
        "magnitude": mutant.subject.magnitude,
        "status": mutant.status.value,
        "kill_rate": share_json(mutant.kill_rate),
        "kill_rate_flown": share_json(mutant.kill_rate_flown),
        "requirements": {name: share_json(ratio) for name, ratio in mutant.requirements},
        "decisions": {
            **{decision.value: len(mutant.decisions(decision)) for decision in Decision},
            "situations": [_decided(r) for r in mutant.results if r.decided and r.decided.look],
        },
    }


def _decided(result: Result) -> dict[str, Any]:
    decided = result.decided
    assert decided is not None
    return {
        "situation": result.situation,
        "decision": decided.decision.value,
        "requirement": decided.requirement,
        "p": decided.p,
        "flights": {"part": decided.k, "whole": decided.n},
        "baseline": {"part": decided.b, "whole": decided.n0},
        "look": decided.look,
    }


def _redraw(scored: Score) -> dict[str, Any]:
    measured, expected = scored.redraw, scored.false_kills
    return {
        "population": "ordered pairs of baseline seeds of one situation, the first of which held a safety requirement",
        "rate": share_json(measured.rate),
        "expected_false_kills": expected[0] if expected else None,
        "eligible_flights": expected[1] if expected else 0,
        "decided": {"seeds": measured.left_out, **share_json(measured.decided)},
        "reason": "" if measured.pairs else NO_PAIRS,
    }
