"""What the page is made from, and what follows from the flights: ladders, margins, limits, thresholds, survivors.

Only a formula that is a conjunction of such bounds is taken apart; any other stays whole: its bounds
alone would say something else.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from datetime import date
from typing import Any

from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.kill_matrix import KillMatrix
from scaloft_fi.analysis.margin import Margin, Scale, lowest, margins, whens
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.score import MutantScore, Score
from scaloft_fi.analysis.suite import NIST, NIST_SOURCE, interactions, minimal_suite, orders, subsumption
from scaloft_fi.analysis.survivor import FAILING, PhasedFault, Tried, backgrounds
from scaloft_fi.campaign.store.held import nothing_to_show
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.hazop.name import cell_of, parse, split_magnitude
from scaloft_fi.judge.bounds import comparisons
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import TRIGGER, Kind, Requirement
from scaloft_fi.judge.stl import COMPARATORS, SAMPLE_MS, Infix, Interval, Node, Prefix, Signal, tokenize
from scaloft_fi.judge.stl import parse as parse_formula
from scaloft_fi.study import Study
from scaloft_fi.verbs.margin import cell_margins, margin_text
from scaloft_fi.verbs.snapshot import NONE, Stale, snapshot
from scaloft_fi.verbs.verdict import short_units, survivors
from scaloft_fi.views.output import by_field, plain


@dataclass(frozen=True)
class Evidence:
    """Everything that the page is made from.

    Attributes:
        study: what was flown.
        campaign: its name, for commands.
        outcomes: those that the study still stands for, with their tracks.
        stale: flights that no longer count.
        owed: flights planned and not flown.
        fingerprint: of the platform that flew them, by name.
        today: by which dispositions expire; None = none does.
        spending: how the campaign spends alpha.
    """

    study: Study
    campaign: str
    outcomes: tuple[Outcome, ...]
    stale: Stale = NONE
    owed: int = 0
    fingerprint: Mapping[str, str] | None = None
    today: date | None = None
    spending: Spending = field(default_factory=Spending)


def gather(study: Study, campaign: str, today: date | None = None) -> Evidence:
    """Read the campaign, all of it at one moment; `today` is the day by which dispositions expire.

    Raises:
        InputError: there is none, or it holds no flight that counts.
    """
    with snapshot(study, campaign) as now:
        known = now.held.current or nothing_to_show(now.store, now.folder)
        return Evidence(
            study=now.study,
            campaign=now.name,
            outcomes=now.with_tracks(known, {outcome.mutant for outcome in known}),
            stale=now.stale,
            owed=now.held.owed,
            fingerprint=now.platform,
            today=today,
            spending=now.spending,
        )


@dataclass(frozen=True)
class Bound:
    """A comparison of a signal with a number.

    Attributes:
        signal: its name.
        sense: of the comparison, as it is written.
        bound: in the signal's own unit.
        for_s: for so long without a break [s]; None where a sample is enough.
        triggered: whether it binds only while the requirement's trigger is true.
    """

    signal: str
    sense: str
    bound: float
    for_s: float | None = None
    triggered: bool = False


def bounds_of(requirements: Iterable[Requirement]) -> list[dict[str, Any]]:
    """Per requirement its `demands` and `when` it applies, as bounds; both empty where a formula is no conjunction."""
    return [_entry(requirement) for requirement in requirements]


def _entry(requirement: Requirement) -> dict[str, Any]:
    defined = {name: parse_formula(tokenize(text)) for name, text in requirement.definitions}
    tree = parse_formula(tokenize(requirement.text))
    inside = tree.of if isinstance(tree, Prefix) and (tree.word, tree.interval) == ("always", None) else None
    demands = inside and _bounds(inside, defined)
    when = _bounds(parse_formula(tokenize(requirement.trigger)), defined) if requirement.trigger else []
    whole = demands is not None and when is not None
    return {
        "name": requirement.name,
        "demands": [asdict(bound) for bound in demands or ()] if whole else [],
        "when": [asdict(bound) for bound in when or ()] if whole else [],
    }


def _bounds(node: Node, defined: Mapping[str, Node]) -> list[Bound] | None:
    """A conjunction as bounds; None where it is something else."""
    match node:
        case Signal(name) if name in defined:
            return _bounds(defined[name], defined)
        case Infix("and", left, right):
            one, other = _bounds(left, defined), _bounds(right, defined)
            return None if one is None or other is None else one + other
        case Infix("implies", Signal(name), right) if name == TRIGGER:
            inner = _bounds(right, defined)
            return inner and [replace(bound, triggered=True) for bound in inner]
        case Prefix("historically", of, Interval(0, last)):
            inner = _bounds(of, defined)
            lasting = inner is not None and all(bound.for_s is None for bound in inner)
            return [replace(bound, for_s=last * SAMPLE_MS / 1000) for bound in inner or ()] if lasting else None
        case Infix(operator) if operator in COMPARATORS:
            return [Bound(signal, sense, bound) for _, signal, sense, bound in comparisons(node)] or None
    return None


def limits(requirements: Iterable[Requirement], signals: Collection[str]) -> list[dict[str, Any]]:
    """Each comparison of one of `signals` with a number; role: `demands`, or `when` the requirement applies.

    A signal that is divided by a number first, as formulas that join units do, has its limit in its own unit.
    """
    limits: list[dict[str, Any]] = []
    for requirement in requirements:
        name, when = requirement.name, [requirement.trigger, *(text for _, text in requirement.definitions)]
        for role, text in (("demands", requirement.text), *(("when", text) for text in when if text)):
            for _, signal, sense, bound in comparisons(parse_formula(tokenize(text))):
                entry = {"signal": signal, "sense": sense, "bound": bound, "role": role, "requirement": name}
                if signal in signals and entry not in limits:
                    limits.append(entry)
    return limits


def by_ladder(cells: Matrix, roster: Roster) -> Callable[[str], tuple[int, int, float, float, str]]:
    """A sort key of ids: the roster's order of cells, then its faults, magnitudes from mild to strong, times, events.

    Magnitudes without an order stay in the catalogue's.
    """

    def key(id_: str) -> tuple[int, int, float, float, str]:
        name = parse(id_)
        place, member = roster.rank(id_)[1:3]
        phase = math.inf if name.event else name.phase_s
        magnitude, unit = split_magnitude(name.magnitude)
        faults = cells.cell(name.cell).faults if name.cell in cells else ()
        for number, fault in enumerate(faults):
            scale = Scale.of(fault.magnitude) if fault.magnitude and fault.magnitude.unit == unit else None
            if scale and not isinstance(magnitude, str):
                return place, number, scale.strength(magnitude), phase, id_
        return place, len(faults), member, phase, id_

    return key


def searched(mutants: Iterable[MutantScore], roster: Roster) -> frozenset[str]:
    """The ids off the catalogue flown in fewer situations than others of their cell: what a search flies."""
    listed = list(mutants)
    flown: dict[str, int] = {}
    for mutant in listed:
        cell = cell_of(mutant.subject.id)
        flown[cell] = max(flown.get(cell, 0), mutant.kill_rate_flown.whole)
    ids = {m.subject.id for m in listed if m.kill_rate_flown.whole < flown[cell_of(m.subject.id)]}
    return frozenset(ids.difference(roster.ids))


def analyses(evidence: Evidence, scored: Score, matrix: KillMatrix) -> dict[str, Any]:
    """By section of the page; of the default mutants only, where ladders would count one fault several times.

    Args:
        evidence: what the page is made from.
        scored: the score of its flights.
        matrix: their kill matrix.
    """
    study, outcomes, roster = evidence.study, evidence.outcomes, evidence.study.roster
    counted = {row.id for row in matrix.mutants if row.counted}
    kills = {id_: keys for id_, keys in matrix.kills.items() if id_ in counted}
    listed = interactions(matrix)
    units, campaign = short_units(study.requirements), evidence.campaign
    known = backgrounds(study.matrix, [row.id for row in matrix.mutants])
    return {
        "margins": margin_texts(outcomes, scored, study.matrix),
        "ladders": ladders(scored, study.matrix, roster),
        "thresholds": thresholds(outcomes, scored, study.matrix, study.requirements),
        "whens": plain(whens(outcomes, scored)),
        "interactions": plain(listed),
        "orders": plain(orders(listed, matrix.space)),
        "nist": {"shares": NIST, "source": NIST_SOURCE},
        "suite": plain(minimal_suite(kills, [key for key, _ in matrix.space.situations])),
        "subsumption": plain(subsumption(kills)),
        "survivors": plain(survivors(outcomes, scored, matrix, known, units, campaign, study.finds)),
    }


def margin_texts(outcomes: Sequence[Outcome], scored: Score, cells: Matrix) -> dict[str, str]:
    """The margin of each cell that has one; faults without an order have a verdict and no margin."""
    margins = {
        cell: [one.text for one in listed if one.margin.known]
        for cell, listed in cell_margins(outcomes, scored, cells).items()
    }
    return {cell: "; ".join(parts) for cell, parts in margins.items() if parts}


def ladders(scored: Score, cells: Matrix, roster: Roster) -> list[dict[str, Any]]:
    """Per cell flown with more than one magnitude its rungs from mild to strong; shifted phases are left out.

    A magnitude that a search flew is left out: its share would be one of situations chosen by their kills.
    """
    by_cell: dict[str, list[MutantScore]] = {}
    order, left_out = by_ladder(cells, roster), searched(scored.mutants, roster)
    for mutant in scored.mutants:
        if mutant.subject.magnitude and "#" not in mutant.subject.id and mutant.subject.id not in left_out:
            by_cell.setdefault(cell_of(mutant.subject.id), []).append(mutant)
    return [
        {
            "cell": cell.name,
            "rungs": [
                {
                    **by_field(rung.subject, "id", "magnitude"),
                    **by_field(rung, "verdict", "kill_rate"),
                    "default": roster.counts(rung.subject),
                }
                for rung in sorted(by_cell[cell.name], key=lambda one: order(one.subject.id))
            ],
        }
        for cell in cells
        if len(by_cell.get(cell.name, [])) > 1
    ]


def thresholds(
    outcomes: Iterable[Outcome], scored: Score, cells: Matrix, requirements: Sequence[Requirement]
) -> list[dict[str, Any]]:
    """Every fault with an order of which some situation has two magnitudes, in the matrix's order of cells.

    Returns:
        Per fault `least`, its margin over all situations, `against`, the names of the requirements that are violated,
        else of those that its cell puts at risk, and per situation the ends of its margin, with the robustness of those
        requirements at both, null where none was put to the test.
    """
    by_fault = margins(outcomes, scored, cells)
    safety = [requirement.name for requirement in requirements if requirement.kind is Kind.SAFETY]
    order = {cell.name: place for place, cell in enumerate(cells)}
    several = [(fault, own) for fault, own in by_fault.items() if any(len(margin.tried) > 1 for margin in own)]
    several.sort(key=lambda entry: (order[entry[0].cell], entry[0].unit, entry[0].phase_s, entry[0].event))
    return [_threshold(fault, own, cells, safety) for fault, own in several]


def _threshold(fault: PhasedFault, listed: Sequence[Margin], cells: Matrix, safety: Sequence[str]) -> dict[str, Any]:
    tried = [tried for margin in listed for tried in margin.tried if tried.reaction in FAILING]
    violated = {name for one in tried for name in one.requirements}
    at_risk = cells.cell(fault.cell).requirements
    against = [name for name in safety if name in (violated or at_risk)] or list(safety)
    least = lowest(listed)
    known = [margin for margin in listed if margin.known]
    return {
        "fault": str(fault),
        "cell": fault.cell,
        "unit": fault.unit,
        "worse": known[0].scale.sign if known else 1,
        "least": margin_text(least) if least else "",
        "situations_flown": len(listed),
        "against": against,
        "situations": [_situation(margin, against) for margin in known],
    }


def _situation(margin: Margin, against: Sequence[str]) -> dict[str, Any]:
    (key,) = margin.situations
    at = {tried.magnitude: tried for tried in margin.tried}
    survivor, strong = (at.get(end) if end is not None else None for end in (margin.survives, margin.end))
    return {
        "key": key,
        "margin": margin_text(margin),
        "survives": finite(margin.survives),
        "seen": finite(margin.seen),
        "kills": finite(margin.kills),
        "by": list(strong.requirements) if strong else [],
        "rho": {name: [_rho(survivor, name), _rho(strong, name)] for name in against},
        "again": [finite(magnitude) for magnitude in margin.again],
        "flown": [finite(magnitude) for magnitude in sorted(at, key=margin.scale.strength)],
    }


def _rho(tried: Tried | None, requirement: str) -> float | str | None:
    rho: Mapping[str, float] = dict(tried.rho) if tried else {}
    return finite(rho.get(requirement))


def finite(value: float | None) -> float | str | None:
    """A number of JSON, which has no infinite ones: those are texts.

    >>> finite(0.5), finite(math.inf), finite(None)
    (0.5, 'inf', None)
    """
    return value if value is None or math.isfinite(value) else f"{value:g}"
