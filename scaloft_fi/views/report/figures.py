"""All figures of the page as plain JSON values; the page draws them and computes none."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from scaloft_fi.analysis.coverage import coverage_of
from scaloft_fi.analysis.detection import Spending, Verdict
from scaloft_fi.analysis.kill_matrix import kill_matrix
from scaloft_fi.analysis.pool import Finding, findings, tallies
from scaloft_fi.analysis.roster import plain
from scaloft_fi.analysis.score import Score, score_of
from scaloft_fi.campaign.runs.gates import check_gates
from scaloft_fi.errors import GateError
from scaloft_fi.judge.outcome import TRACK_COLUMNS
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.status import rulings_of
from scaloft_fi.sim.log import Ending
from scaloft_fi.version import __version__
from scaloft_fi.views.glossary import TERMS
from scaloft_fi.views.report import matrices
from scaloft_fi.views.report.accepted import accepted
from scaloft_fi.views.report.analyses import analyses
from scaloft_fi.views.report.bounds import bounds_of
from scaloft_fi.views.report.breaks import broken
from scaloft_fi.views.report.certainty import steps
from scaloft_fi.views.report.evidence import Evidence
from scaloft_fi.views.report.finds import found
from scaloft_fi.views.report.head import head
from scaloft_fi.views.report.karnaugh import folding
from scaloft_fi.views.report.ladder import by_ladder
from scaloft_fi.views.report.limits import limits
from scaloft_fi.views.report.scenes import scenes
from scaloft_fi.views.report.tracks import FAR
from scaloft_fi.views.score.answers import answers
from scaloft_fi.views.score.first_screen import coverage_line
from scaloft_fi.views.score.score_record import score_json
from scaloft_fi.views.score.tables import POPULATIONS

SCHEMA = 5
"""Version of the JSON in the page."""


def figures(evidence: Evidence) -> dict[str, Any]:
    """The page's figures.

    Raises:
        InputError: a part of the study is not what it should be.
    """
    study, outcomes = evidence.study, evidence.outcomes
    roster, space = study.roster, study.space.holding(outcome.situation for outcome in outcomes)
    rulings = rulings_of(outcomes)
    scored = score_of(rulings, roster, space, evidence.spending)
    order = matrices.situations(space, study.grid)
    keys = [situation["key"] for situation in order]
    kills = kill_matrix(scored, roster, space)
    covered = coverage_of(rulings.baselines, rulings.draws, space)
    record = score_json(scored, covered, [])
    listed = (*record["mutants"], *record["controls"])
    standing = scenes(study, sorted({outcome.situation for outcome in outcomes} & set(keys)))
    breaks = broken(study.finds, standing["mines"])
    mutants = matrices.mutants(scored, kills, rulings, listed, roster, keys, by_ladder(study.matrix, roster))
    return {
        "schema": SCHEMA,
        "version": __version__,
        "study": study.name,
        "campaign": evidence.campaign,
        "grid": space.grid,
        "seeds": sorted({seed for _, seed in rulings.draws}),
        "flights": len(outcomes),
        "stale": list(evidence.stale.sentences),
        "owed": evidence.owed,
        "fingerprint": dict(evidence.fingerprint or {}),
        "answers": plain(answers(scored, roster, evidence.campaign, study.finds, space.grid)),
        "head": head(scored, covered.situations, len(breaks)),
        "besides": [{"name": "Situations", "text": coverage_line(covered)}],
        "pooled": scored.pooled,
        "ratios": [
            {"name": name, "title": name.replace("_", " "), "population": population} | record["ratios"][name]
            for name, population in POPULATIONS.items()
        ],
        "coverage": record["coverage"],
        "gates": _gates(evidence, scored, mutants),
        "signs": matrices.SIGNS,
        "certainty": steps(scored.alpha),
        "verdicts": [verdict.value for verdict in Verdict],
        "axes": matrices.axes(study.grid),
        "karnaugh": folding(space),
        "situations": order,
        "by_situation": matrices.by_situation(scored, roster, keys),
        "guidewords": plain(study.matrix.guidewords),
        "parameters": plain(study.matrix.parameters),
        "severities": plain(study.matrix.classes),
        "cells": matrices.cells(study.matrix, [mutant["id"] for mutant in mutants]),
        "mutants": mutants,
        "requirements": plain(study.requirements),
        "limits": limits(study.requirements, TRACK_COLUMNS),
        "bounds": bounds_of(study.requirements),
        "pairs": record["pairs"],
        "firsts": [_first(finding) for finding in findings(outcomes, space) if finding.first],
        "tallies": [{**plain(tally), "compliances": plain(dict(tally.compliances))} for tally in tallies(outcomes)],
        "accepted": accepted(scored, roster, study.dispositions, evidence.today),
        **analyses(evidence, scored, kills),
        "far": FAR,
        "endings": {ending.value: ending.sentence for ending in Ending},
        "scenes": standing,
        "found": found(study, evidence.campaign, outcomes, standing["mines"]),
        "breaks": breaks,
        "glossary": plain(TERMS),
    }


def _gates(evidence: Evidence, scored: Score, mutants: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """What the gates of a campaign say of these flights, and the counts behind them."""
    outcomes, roster = evidence.outcomes, evidence.study.roster
    flown = {outcome.situation for outcome in outcomes}
    try:
        check_gates(
            outcomes,
            roster,
            canary=None,
            whole_grid=flown == evidence.study.space.point.keys(),
            deterministic=evidence.study.stack.deterministic,
            spending=Spending(scored.alpha),
        )
        failed = ""
    except GateError as error:
        failed = str(error)
    placebo = sum(count for _, count in scored.placebo.statuses) if scored.placebo else 0
    controls = [bool(mutant["shows"]) for mutant in mutants if mutant["control"]]
    steady = sum(bool(scored.pool.steady(key, Kind.SAFETY)) for key in scored.pool.flown)
    return {
        "failed": failed,
        "placebo_flights": placebo,
        "invalid_flights": sum(bool(outcome.invalid) for outcome in outcomes),
        "controls": {"part": sum(controls), "whole": len(controls)},
        "steady_situations": {"part": steady, "whole": len(scored.pool.flown)},
    }


def _first(finding: Finding) -> dict[str, Any]:
    """The earliest safety violation of the unmutated drone in a situation."""
    assert finding.first
    violation, seed = finding.first
    return {**plain(violation), "seed": seed, "situation": finding.situation}
