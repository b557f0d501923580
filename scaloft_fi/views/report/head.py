"""The top of the page: what the unmutated drone fails by itself, and what the figures do not claim."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.pool import Pool, State
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.analysis.score import Score
from scaloft_fi.judge.requirement import Kind
from scaloft_fi.views.score.answers import NOT_COMPARED

NO_POOL = "Not known: no situation has ten flights of the unmutated drone."
WHOLE = "A share of these faults and no estimate for others: the list of cells is closed, and no sample of anything."
MODEL = (
    "The flights are simulated: mine, vehicle, sensors and light are a model, many of whose numbers are assumptions."
)


def head(scored: Score, situations: Ratio, breaks: int) -> dict[str, Any]:
    """The sentences of the top of the page.

    Args:
        scored: the campaign's score.
        situations: flown, of those of the grid.
        breaks: situations beside the grid that a search found to break the unmutated drone.

    Returns:
        `fails`: of the unmutated drone; `claims`: what is not claimed.
    """
    return {"fails": [*fails(scored.pool), *_broken(breaks)], "claims": list(_claims(scored, situations))}


def fails(pool: Pool) -> list[str]:
    """What the unmutated drone fails: a sentence a safety requirement, and one on what that takes from the test."""
    if not pool.flown:
        return [NO_POOL]
    names = pool.requirements(Kind.SAFETY)
    sentences = [sentence for name in names if (sentence := _violates(pool, name))]
    if not sentences:
        return [f"In none of the {len(pool.flown)} situations with a pool does it violate a safety requirement often."]
    lost = sum(not pool.steady(key, Kind.SAFETY) for key in pool.flown)
    where = f"No fault is put to the safety test in {lost} of these {len(pool.flown)} situations" if lost else ""
    return [*sentences, *([f"{where}: no safety requirement is steady there."] if lost else [])]


def _violates(pool: Pool, name: str) -> str:
    """Where the unmutated drone violates a requirement; empty where it does so nowhere often."""
    states = Counter(pool.states[key, name] for key in pool.flown)
    often = {State.RED: "in most flights of", State.UNSTEADY: "now and then in"}
    parts = [f"{words} {states[state]}" for state, words in often.items() if states[state]]
    return f"It violates {name} {' and '.join(parts)} of {_situations(len(pool.flown))}." if parts else ""


def _broken(breaks: int) -> Iterable[str]:
    if breaks:
        they = "breaks" if breaks == 1 else "break"
        yield f"A search around the grid found {_situations(breaks)} more that {they} it."


def _claims(scored: Score, situations: Ratio) -> Iterable[str]:
    """What is not claimed, the most misleading first."""
    yield WHOLE
    yield NOT_COMPARED
    fates = Counter(mutant.verdict for mutant in scored.counted)
    unsure = {Verdict.UNDECIDED: "undecided", Verdict.NOT_TESTED: "never put to the test"}
    parts = [f"{fates[verdict]} {words}" for verdict, words in unsure.items() if fates[verdict]]
    if scored.pooled and parts:
        yield f"Nothing is said of the faults that are not decided: {', '.join(parts)}."
    if scored.selected:
        yield f"{_situations(len(scored.selected))} {_were(len(scored.selected))} chosen because of verdicts."
    if situations.part < situations.whole:
        yield f"Only {situations.part} of {_situations(situations.whole)} of the grid were flown."
    yield MODEL


def _were(count: int) -> str:
    return "was" if count == 1 else "were"


def _situations(count: int) -> str:
    return f"{count} situation{'s' * (count != 1)}"
