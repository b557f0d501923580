"""The score as plain JSON values: the form of what `score` and `run` print with `--format json`, and its values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from scaloft_fi.analysis.coverage import Coverage
from scaloft_fi.analysis.detection import Detection, Firmness, Noise, Verdict
from scaloft_fi.analysis.pool import State
from scaloft_fi.analysis.roster import plain
from scaloft_fi.analysis.score import By, FirstViolation, Group, Kill, MutantScore, Score
from scaloft_fi.analysis.survivor import Accepted, score_without
from scaloft_fi.hazop.matrix import class_of
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.status import Status
from scaloft_fi.verbs.coverage import COVERED, coverage_record
from scaloft_fi.verbs.snapshot import NONE, STALE, Stale
from scaloft_fi.verbs.verdict import ACCEPTED, accepted_values
from scaloft_fi.views.output import (
    Output,
    Shape,
    by_name,
    count,
    flag,
    listing,
    number,
    optional,
    ratio,
    record,
    text,
    texts,
)

VERDICTS = [verdict.value for verdict in Verdict]
FIRM = optional(
    text("whether it stays detected when any one seed is left out", [firmness.value for firmness in Firmness]),
    "it is not detected",
)
SITUATION = text("key of the situation")
REQUIREMENT = text("name of the requirement")
SEVERITY = optional(text("class of severity, one of the study's own; in no ratio"), "it has none")
P = by_name(
    "by requirement, the chance of as many violations if the fault did nothing (exact test, Holm's adjustment)",
    number("p (0..1)"),
)
_KILLS = listing(
    "steady pairs in which most of its flights violate, if it is detected",
    record(
        "a kill",
        {
            "situation": SITUATION,
            "requirement": REQUIREMENT,
            "violated": count("flights that violate the requirement"),
            "flights": count("flights that count"),
        },
    ),
)
_DECIDED = record(
    "what the verdict rests on",
    {
        "seeds": count("seeds that it rests on"),
        "alpha": number("the share of alpha that p is held against (0..1)"),
        "needed": optional(count("seeds that would decide it, if what was seen goes on"), "decided, or none would"),
        "anew": flag("whether that takes a campaign of its own"),
    },
)
_FIRST = record(
    "its earliest safety violation that the baseline beside it holds",
    {
        "requirement": REQUIREMENT,
        "t_s": number("time", "s from take-off"),
        "situation": SITUATION,
        "seed": count("seed of the flight"),
        "position": listing("x, y, z of the vehicle", {"type": "number", "description": "coordinate [m, world]"}),
        "struck": text("name of the body that was struck; empty for none"),
    },
)


def _mutants(about: str) -> Shape:
    return listing(
        about,
        record(
            "a mutant",
            {
                "id": text("canonical id"),
                "guideword": text("its guideword"),
                "parameter": text("its parameter"),
                "magnitude": text("its magnitude with the unit, as in the id; empty where the cell has no ladder"),
                "severity": SEVERITY,
                "status": text("the furthest stage that a flight reached", [status.value for status in Status]),
                "verdict": text("of all its flights, by safety requirements", VERDICTS),
                "firm": FIRM,
                "p": P,
                "kill_rate": ratio("situations with a kill, of those that put it to the test"),
                "kill_rate_flown": ratio("situations with a kill, of those flown"),
                "kills": _KILLS,
                "requirements": by_name(
                    "by requirement that kills it", ratio("situations with such a kill, of those that test it by it")
                ),
                "first": optional(_FIRST, "there is none"),
                "decided_at": _DECIDED,
                "operability": record(
                    "the same by operability requirements",
                    {
                        "verdict": text("by operability requirements", VERDICTS),
                        "p": P,
                        "kills": _KILLS,
                        "decided_at": _DECIDED,
                    },
                ),
            },
        ),
    )


SCORE = Output(
    "score",
    "3.1",
    "which faults the requirements would have shown",
    {
        "alpha": number("accepted chance that a fault which does nothing is called detected (0..1)"),
        "pooled": flag("whether there is a baseline pool to decide by where mutants infect"),
        "ratios": record(
            "the ratios, over the default mutants of credible cells",
            {
                "exercised": ratio("cells flown, of all credible cells"),
                "infected": ratio("mutants that changed a sample, of those flown"),
                "tested": ratio("mutants put to the test, of those flown"),
                "mutation_score": ratio("mutants detected by safety requirements, of those flown"),
                "firm": ratio("mutants detected whichever one seed is left out, of those flown"),
                "without_accepted": ratio("the same, of those flown that are no accepted survivors"),
                "operability": ratio("mutants detected by operability requirements, of those flown"),
            },
        ),
        "expected_false": number("mutants that would be called detected if none had any effect, expected at most"),
        "redraw": record(
            "how often redraws of the unmutated drone are called detected",
            {
                "seeds": count("flights of a redraw in each situation; 0: none was made"),
                "safety": ratio("redraws detected by safety requirements, of all"),
                "operability": ratio("redraws detected by operability requirements, of all"),
            },
        ),
        "composition": record(
            "what the ratio is made of, over the default mutants of credible cells",
            {
                "behaviours": listing(
                    "the detected mutants; those whose flights all equal each other's to the bit together",
                    texts("ids of mutants that fly alike"),
                ),
                "without_kill": texts("ids of detected mutants of which most flights violate in no situation"),
                "trivial": texts(
                    "ids of mutants killed in nine tenths of the situations that test them, or within 5 s of take-off"
                ),
                "without_effect": listing(
                    "the mutants whose flights all equal the baseline's to the bit",
                    record(
                        "a mutant",
                        {
                            "id": text("canonical id"),
                            "acted": ratio("flights in which it changed a sample, of those that count"),
                        },
                    ),
                ),
            },
        ),
        "mutants": _mutants("every mutant flown, in the canonical order"),
        "controls": _mutants("every control flown; no ratio counts them"),
        "pairs": listing(
            "what the baseline pool says of each requirement in each situation",
            record(
                "a pair",
                {
                    "situation": SITUATION,
                    "requirement": REQUIREMENT,
                    "kind": text("of the requirement", [kind.value for kind in Kind]),
                    "flights": count("of the baseline"),
                    "violated": count("flights that violate the requirement"),
                    "open": count("flights cut short before it was judged"),
                    "triggered": count("flights in which its condition came true, or that violate it"),
                    "state": text("what the pool says", [state.value for state in State]),
                },
            ),
        ),
        "lacking": texts("keys of situations where a mutant infects and the pool has too few flights"),
        "selected": texts("keys of situations flown that a search found because of verdicts"),
        "coverage": COVERED,
        "baseline": listing(
            "what the unmutated drone violates",
            record(
                "a situation",
                {"situation": SITUATION, "violated": texts("requirements that any of its flights violates")},
            ),
        ),
        "groups": listing(
            "with `--by`, the score part by part, over the default mutants of credible cells; else empty",
            record(
                "a part",
                {
                    "by": text("what the parts are", [by.value for by in By]),
                    "name": text(
                        "of the part: a guideword, a parameter, a class of severity (worst first, `no class` last), a "
                        "key, a requirement, an axis with its value"
                    ),
                    "axis": optional(text("id of the axis"), "not by axis"),
                    "value": optional(text("id of the axis's value, as in keys of situations"), "not by axis"),
                    "tested": ratio(
                        "mutants detected, of those put to the test; by situation and by axis mutants in situations "
                        "with a kill"
                    ),
                    "flown": ratio("the same, of those flown"),
                },
            ),
        ),
        "noise": listing(
            "of a stack that is not deterministic: the noise of robustness; else empty",
            record(
                "noise of a requirement's robustness, in the requirement's own unit",
                {
                    "requirement": REQUIREMENT,
                    "pairs": count("pairs of flights of one situation and seed"),
                    "stack": optional(number("standard deviation by the stack alone"), "there is no pair"),
                    "seeds": optional(
                        number("standard deviation between the seeds of a situation"), "no situation has two baselines"
                    ),
                    "apart": count("pairs of which one flight violates it and the other one holds it"),
                },
            ),
        ),
        "looks": listing(
            "of `run --sequential`: its looks; else empty",
            record(
                "a look",
                {
                    "seeds": count("seeds at this look"),
                    "mutants": count("mutants judged"),
                    "flights": count("of these mutants, planned for the look"),
                    **{verdict: count(f"mutants {verdict.replace('_', ' ')}") for verdict in VERDICTS},
                },
            ),
        ),
        "unflown": listing(
            "of `run --budget`: where planned flights were not flown; else empty",
            record(
                "a part of the plan",
                {
                    "by": text("what the parts are", ["parameter", "situation"]),
                    "name": text("of the part: a parameter or a subject, or the key of a situation"),
                    "planned": count("flights"),
                    "flown": count("of these flights, flown"),
                    "not_flown": count("of these flights, not flown"),
                },
            ),
        ),
        "accepted": ACCEPTED,
        **STALE,
    },
    rows="mutants",
)
RUN = replace(SCORE, verb="run", about="what was flown: the form of `score`, with how the run went")


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


def _moment(moment: FirstViolation | None) -> dict[str, Any] | None:
    if moment is None:
        return None
    return moment._asdict() | {"position": list(moment.position)}
