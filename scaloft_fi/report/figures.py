"""All figures of the page as plain JSON values; the page draws them and computes none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from scaloft_fi import __version__
from scaloft_fi.campaign.runs.gates import check
from scaloft_fi.errors import GateError
from scaloft_fi.report import matrices
from scaloft_fi.report.accepted import accepted
from scaloft_fi.report.analyses import analyses
from scaloft_fi.report.bounds import bounds_of
from scaloft_fi.report.evidence import Evidence
from scaloft_fi.report.karnaugh import folding
from scaloft_fi.report.limits import limits
from scaloft_fi.report.scenes import scenes
from scaloft_fi.report.severity import by_severity
from scaloft_fi.report.tracks import FAR
from scaloft_fi.results.kills.kill_matrix import kill_matrix
from scaloft_fi.results.scoring.baseline import Finding, Tally, findings, tallies
from scaloft_fi.results.scoring.ratio import ratio_json
from scaloft_fi.results.scoring.score import MutantScore, Score, score
from scaloft_fi.results.scoring.score_record import score_json
from scaloft_fi.results.scoring.tables import ratio_table
from scaloft_fi.results.situations.coverage import coverage
from scaloft_fi.results.status import Status
from scaloft_fi.results.track import TRACK_COLUMNS
from scaloft_fi.sim.log import Ending

SCHEMA = 1
"""Version of the JSON in the page."""
RATIOS = ("exercised", "infected", "mutation_score", "strict_score", "decided_score", "operability")


def figures(evidence: Evidence) -> dict[str, Any]:
    """The page's figures.

    Raises:
        InputError: a part of the study is not what it should be.
    """
    study, outcomes = evidence.study, evidence.outcomes
    roster, space = study.roster, study.space
    scored = score(outcomes, roster, space)
    found = findings(outcomes, space)
    seeds = sorted({outcome.seed for outcome in outcomes if not outcome.invalid})
    order = matrices.situations(space, study.grid)
    keys = [situation["key"] for situation in order]
    kills = kill_matrix(scored, roster, space)
    mutants = matrices.mutants(scored, kills, roster, keys, by_severity(study.matrix, roster))
    covered = coverage(outcomes, space)
    told = score_json(scored, covered, [])
    return {
        "schema": SCHEMA,
        "version": __version__,
        "study": study.folder.resolve().name,
        "campaign": evidence.campaign,
        "seeds": seeds,
        "flights": len(outcomes),
        "stale": evidence.stale,
        "owed": evidence.owed,
        "fingerprint": dict(evidence.fingerprint or {}),
        "ratios": _ratios(scored, len(seeds)),
        "coverage": told["coverage"],
        "redraw": told["redraw"],
        "gates": _gates(evidence, scored, found),
        "statuses": matrices.STATUSES,
        "decisions": matrices.DECISIONS,
        "axes": matrices.axes(study.grid),
        "karnaugh": folding(space, [axis.title for axis in study.grid.axes]),
        "situations": order,
        "by_situation": matrices.by_situation(scored, roster, keys),
        "guidewords": [asdict(word) for word in study.matrix.guidewords],
        "parameters": [asdict(parameter) for parameter in study.matrix.parameters],
        "cells": matrices.cells(study.matrix, [mutant["id"] for mutant in mutants]),
        "mutants": mutants,
        "fates": {status.value: scored.fates.get(status, 0) for status in Status},
        "requirements": [asdict(requirement) | {"kind": requirement.kind.value} for requirement in study.requirements],
        "limits": limits(study.requirements, TRACK_COLUMNS),
        "bounds": bounds_of(study.requirements),
        "baseline": [_finding(finding) for finding in found],
        "tallies": [_tally(tally) for tally in tallies(outcomes)],
        "accepted": accepted(scored, roster, study.dispositions, evidence.today),
        **analyses(outcomes, scored, kills, study, roster),
        "far": FAR,
        "endings": {ending.value: ending.sentence for ending in Ending},
        "scenes": scenes(study, sorted({outcome.situation for outcome in outcomes} & set(keys))),
    }


def _ratios(scored: Score, seeds: int) -> list[dict[str, Any]]:
    """The ratios, each with its interval and the population that it speaks of."""
    rows = ratio_table(scored, seeds).rows
    return [
        {"name": name, "title": str(row[0]), "population": str(row[2])} | ratio_json(getattr(scored, name))
        for name, row in zip(RATIOS, rows, strict=True)
    ]


def _gates(evidence: Evidence, scored: Score, found: Sequence[Finding]) -> dict[str, Any]:
    """What the gates of a campaign say of these flights, and the counts behind them."""
    outcomes, roster = evidence.outcomes, evidence.study.roster
    flown = {outcome.situation for outcome in outcomes}
    try:
        check(outcomes, roster, canary=None, whole_grid=len(flown) == len(evidence.study.space.points))
        failed = ""
    except GateError as error:
        failed = str(error)
    placebo = sum(count for _, count in scored.placebo.rungs) if scored.placebo else 0
    return {
        "failed": failed,
        "placebo_flights": placebo,
        "invalid_flights": sum(bool(outcome.invalid) for outcome in outcomes),
        "controls": {"part": sum(_shows(control) for control in scored.controls), "whole": len(scored.controls)},
        "green_situations": {"part": sum(finding.red == 0 for finding in found), "whole": len(found)},
    }


def _shows(control: MutantScore) -> bool:
    return bool(control.killing or control.operability.part)


def _finding(finding: Finding) -> dict[str, Any]:
    first = None
    if finding.first:
        violation, seed = finding.first
        first = asdict(violation) | {"kind": violation.kind.value, "seed": seed}
    return asdict(finding) | {"first": first}


def _tally(tally: Tally) -> dict[str, Any]:
    verdicts = {verdict.value: count for verdict, count in tally.verdicts}
    return asdict(tally) | {"kind": tally.kind.value, "verdicts": verdicts}
