"""The page of the report: figures and flights as data, style and script inlined, nothing fetched."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import zlib
from collections import Counter
from collections.abc import Iterable, Mapping
from importlib.resources import files
from typing import Any

from scaloft_fi.analysis.coverage import coverage_of
from scaloft_fi.analysis.detection import Firmness, Pool, State, Verdict, findings, tallies
from scaloft_fi.analysis.kill_matrix import kill_matrix
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import Score, score_of
from scaloft_fi.campaign.store.archive import flown_in
from scaloft_fi.defaults import __version__
from scaloft_fi.hazop.matrix import class_of, worst_first
from scaloft_fi.judge.outcome import TRACK_COLUMNS
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.judge.status import rulings_of
from scaloft_fi.output import all_printable, in_campaign
from scaloft_fi.sim.log import Ending
from scaloft_fi.verbs.first_screen import BEFOREHAND, NOT_COMPARED, answers, coverage_line, ratios_of, selected
from scaloft_fi.verbs.report import analyses
from scaloft_fi.verbs.report.analyses import Evidence
from scaloft_fi.verbs.report.flights import DETAILS, FAR, broken, columns, found, packs, scenes
from scaloft_fi.views.output import plain
from scaloft_fi.views.table import TERMS, counted, of_tests_words

NO_POOL = "Not known: no situation has ten flights of the unmutated drone."
WHOLE = "A share of these faults and no estimate for others: the list of cells is closed, and no sample of anything."
MODEL = (
    "The flights are simulated: mine, vehicle, sensors and light are a model, many of whose numbers are assumptions."
)


def head(scored: Score, situations: Ratio, breaks: int, chosen: Iterable[str] = ()) -> dict[str, Any]:
    """The sentences of the top of the page.

    Args:
        scored: the campaign's score.
        situations: flown, of those of the grid.
        breaks: situations beside the grid that a search found to break the unmutated drone.
        chosen: what was chosen because of flights such as these, each in a clause.

    Returns:
        `answer`, `sure`, `claim`: a sentence each for the first screen; `fails`: of the unmutated drone; `claims`: all
        that is not claimed.
    """
    they = "breaks" if breaks == 1 else "break"
    broken = [f"A search around the grid found {counted(breaks, 'situation')} more that {they} it."] if breaks else []
    beyond = " or other tests" if scored.of_tests else ", another drone, or a flight that is not simulated"
    return {
        "answer": _answer(scored),
        "sure": _sure(scored),
        "claim": f"anything of other faults{beyond}.",
        "fails": [*fails(scored.pool), *broken],
        "claims": [*_claims(scored, situations, chosen), *([] if scored.of_tests else [MODEL])],
    }


def _answer(scored: Score) -> str:
    """How many faults are shown and how many are missed, of which class the worst are, in a sentence."""
    faults = scored.faults
    if not scored.pooled:
        return NO_POOL
    if not faults:
        return "No fault was flown."
    shown = sum(mutant.detected for mutant in faults)
    missed = [one for one in faults if one.verdict is Verdict.NOT_DETECTED and not one.without_effect]
    said = f"Your safety requirements show {shown} of {counted(len(faults), 'fault')} and miss {len(missed) or 'none'}"
    if not missed and (open_ := sum(one.verdict is Verdict.UNDECIDED for one in faults)):
        said += f"; {open_} {'is' if open_ == 1 else 'are'} undecided"
    ranked = worst_first([one for one in missed if one.severity], lambda one: one.severity)
    if not ranked:
        return f"{said}."
    named = class_of(ranked[0].severity)
    worst = sum(class_of(one.severity) == named for one in ranked)
    among = f"; {worst} of the missed {'are' if worst > 1 else 'is'}" if worst < len(missed) else ","
    return f"{said}{among} of the class {named}."


def _sure(scored: Score) -> str:
    """How sure the answer is."""
    if not scored.pooled:
        return "not at all, so nothing is called shown."
    if not any(mutant.tested for mutant in scored.faults):
        return "of nothing: no fault was put to the test."
    shown = [mutant for mutant in scored.faults if mutant.detected]
    firm = sum(mutant.firm for mutant in shown)
    alone = sum(mutant.firmness is Firmness.FIRM_BY_POOL for mutant in shown)
    stay = f"{firm} stay{'s' * (firm == 1)} shown whichever one seed is left out"
    kept = f"  Of the {len(shown)} shown, {stay}" if shown else ""
    kept += f" ({alone} by the baseline's alone, as they have one seed)" if alone else ""
    missed = "  A missed fault may show in other situations." if len(shown) < len(scored.faults) else ""
    chance = f"a fault that does nothing is called shown with a chance of at most {scored.alpha:g}, {BEFOREHAND}."
    return f"{chance}{kept}{'.' * bool(kept)}{missed}"


def fails(pool: Pool) -> list[str]:
    """What the unmutated drone fails: a sentence a safety requirement, and one on what that takes from the test."""
    if not pool.flown:
        return [NO_POOL]
    often, sentences = {State.RED: "in most flights of", State.UNSTEADY: "now and then in"}, []
    for name in pool.requirements(Kind.SAFETY):
        states = Counter(pool.states[key, name] for key in pool.flown)
        if parts := [f"{words} {states[state]}" for state, words in often.items() if states[state]]:
            sentences.append(f"It violates {name} {' and '.join(parts)} of {counted(len(pool.flown), 'situation')}.")
    if not sentences:
        return [f"In none of the {len(pool.flown)} situations with a pool does it violate a safety requirement often."]
    lost = sum(not pool.steady(key, Kind.SAFETY) for key in pool.flown)
    where = f"No fault is put to the safety test in {lost} of these {len(pool.flown)} situations" if lost else ""
    return [*sentences, *([f"{where}: no safety requirement is steady there."] if lost else [])]


def _claims(scored: Score, situations: Ratio, chosen: Iterable[str]) -> Iterable[str]:
    """What is not claimed, the most misleading first."""
    yield WHOLE
    yield NOT_COMPARED
    fates = Counter(mutant.verdict for mutant in scored.counted)
    unsure = {Verdict.UNDECIDED: "undecided", Verdict.NOT_TESTED: "never put to the test"}
    parts = [f"{fates[verdict]} {words}" for verdict, words in unsure.items() if fates[verdict]]
    if scored.pooled and parts:
        yield f"Nothing is said of the faults that are not decided: {', '.join(parts)}."
    yield from (f"{told}." for told in chosen)
    if situations.part < situations.whole:
        yield f"Only {situations.part} of {counted(situations.whole, 'situation')} of the grid were flown."


SCHEMA = 7
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
    order = analyses.situations(space, study.grid)
    keys = [situation["key"] for situation in order]
    kills = kill_matrix(scored, roster, space)
    covered = coverage_of(rulings.baselines, rulings.draws, space)
    ratios, listed = plain(scored), plain((*scored.mutants, *scored.controls))
    standing = scenes(study, sorted({outcome.situation for outcome in outcomes} & set(keys)))
    breaks = broken(study.finds, standing["mines"])
    mutants = analyses.mutants(scored, kills, rulings, listed, roster, keys, analyses.by_ladder(study.matrix, roster))
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
        "answers": plain(answers(scored, study, evidence.campaign, evidence.stale.invalid)),
        "head": head(scored, covered.situations, len(breaks), selected(scored, study)),
        "besides": [] if scored.of_tests else [{"name": "Situations", "text": coverage_line(covered)}],
        "again": study.again,
        "where": in_campaign(flown_in(evidence.campaign)),
        "anew": in_campaign("NEW"),
        "words": list(of_tests_words().items()) if scored.of_tests else [],
        "pooled": scored.pooled,
        "ratios": [
            {"name": one.key, "title": one.key.replace("_", " "), "population": one.about, **ratios[one.key]}
            for one in ratios_of(scored)
        ],
        "coverage": plain(covered),
        "gates": _gates(evidence, scored, mutants),
        "signs": analyses.SIGNS,
        "certainty": analyses.steps(scored.alpha),
        "verdicts": [verdict.value for verdict in Verdict],
        "axes": [] if scored.of_tests else analyses.axes(study.grid),
        "karnaugh": analyses.folding(space),
        "situations": order,
        "by_situation": analyses.by_situation(scored, roster, keys),
        "guidewords": plain(study.matrix.guidewords),
        "parameters": plain(study.matrix.parameters),
        "severities": plain(study.matrix.classes),
        "cells": analyses.cells(study.matrix, [mutant["id"] for mutant in mutants]),
        "mutants": mutants,
        "requirements": plain(study.requirements),
        "limits": analyses.limits(study.requirements, TRACK_COLUMNS),
        "bounds": analyses.bounds_of(study.requirements),
        "pairs": [
            {**plain(pair), "called": pair.called(of_tests=scored.of_tests).value}
            for pair in scored.pool.pairs.values()
        ],
        "firsts": [
            {**plain(finding.first[0]), "seed": finding.first[1], "situation": finding.situation}
            for finding in findings(outcomes, space)
            if finding.first
        ],
        "tallies": [{**plain(tally), "compliances": plain(dict(tally.compliances))} for tally in tallies(outcomes)],
        "accepted": analyses.accepted(scored, roster, study.dispositions, evidence.today),
        **analyses.analyses(evidence, scored, kills),
        "far": FAR,
        "endings": {ending.value: ending.sentence for ending in Ending},
        "scenes": standing,
        "found": found(study, evidence.campaign, outcomes, standing["mines"]),
        "breaks": breaks,
        "glossary": plain(TERMS),
    }


def _gates(evidence: Evidence, scored: Score, mutants: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """What the gates of a campaign say of these flights, and the counts behind them."""
    placebo = sum(count for _, count in scored.placebo.statuses) if scored.placebo else 0
    controls = [bool(mutant["shows"]) for mutant in mutants if mutant["control"]]
    steady = sum(bool(scored.pool.steady(key, Kind.SAFETY)) for key in scored.pool.flown)
    return {
        "failed": "; ".join(evidence.stale.invalid),
        "placebo_flights": placebo,
        "deterministic": evidence.study.stack.deterministic,
        "invalid_flights": sum(bool(outcome.invalid) for outcome in evidence.outcomes),
        "controls": plain(Ratio(sum(controls), len(controls))),
        "steady_situations": plain(Ratio(steady, len(scored.pool.flown))),
    }


MOST_BYTES = 5_000_000
"""The page fits into an e-mail."""
SAMPLE, HOPELESS = 8, 1.3
"""Every eighth situation is packed first; what it promises to exceed so far is not tried on all."""
STYLES = ("page.css", "matrices.css", "karnaugh.css", "flight.css")
SCRIPTS = (
    *("dom.js", "text.js", "data.js", "glossary.js", "charts.js", "head.js", "hazop.js", "kills.js", "map.js"),
    *("player.js", "situation.js", "flight.js", "accepted.js", "karnaugh.js", "mutant.js", "margins.js", "cell.js"),
    *("follows.js", "found.js", "breaks.js", "sections.js", "paper.js", "main.js"),
)
"""In the order in which they are joined; each is a part of one strict script."""


def page(evidence: Evidence, most_bytes: int = MOST_BYTES) -> str:
    """The whole report as the text of one HTML file, with as many tracks as fit into `most_bytes`.

    Raises:
        InputError: a part of the study is not what it should be.
    """
    content, pairs = figures(evidence), evidence.listed
    outcomes = [one for one in evidence.outcomes if pairs is None or (one.situation, one.seed) in pairs]
    names = [requirement.name for requirement in evidence.study.requirements]
    text = ""
    for detail in DETAILS:
        sample = sum(map(len, packs(outcomes, names, detail, SAMPLE).texts.values()))
        if detail is not DETAILS[-1] and sample * SAMPLE > HOPELESS * most_bytes:
            continue
        packed = packs(outcomes, names, detail)
        told = {"detail": packed.says, "columns": columns(detail), "listed": len(outcomes)}
        text = html(content | told, packed.texts)
        if len(text.encode()) <= most_bytes:
            break
    return text


def html(content: Mapping[str, Any], packed: Mapping[str, str]) -> str:
    """The page of these figures and packs of flights."""
    style = "\n".join(map(asset, STYLES))
    script = '"use strict";\n(async () => {\n' + "\n".join(map(asset, SCRIPTS)) + "\n})();\n"
    sources = f"style-src '{_hash(style)}'; script-src '{_hash(script)}'"
    policy = f"default-src 'none'; img-src data:; {sources}; base-uri 'none'; form-action 'none'"
    parts = {"POLICY": policy, "STYLE": style, "SCRIPT": script}
    parts |= {"FIGURES": inert(deflated(content)), "FLIGHTS": inert(packed)}
    # in one pass, so that no part is searched for the places of others
    return re.sub(r"@([A-Z]+)@", lambda place: parts[place[1]], asset("page.html"))


def deflated(values: Any) -> str:
    """The base64 text of JSON of printable texts, deflated: that of 250,000 flights is an eighth of its size."""
    return base64.b64encode(zlib.compress(_json(values).encode(), zlib.Z_BEST_COMPRESSION)).decode()


def inert(values: Any) -> str:
    """JSON of printable texts that nothing in HTML can take for markup: no `<`, `>` or `&` is left in it."""
    return _json(values).replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _json(values: Any) -> str:
    return json.dumps(all_printable(values), ensure_ascii=True, allow_nan=False, separators=(",", ":"))


def asset(name: str) -> str:
    """The text of a file in `assets/`."""
    return files("scaloft_fi.verbs.report").joinpath("assets", name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    """A source expression of a Content Security Policy (W3C CSP level 3) that admits this text only."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
