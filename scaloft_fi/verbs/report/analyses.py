"""What the page is made from, and what follows from the flights: ladders, margins, limits, thresholds, survivors.

Only a formula that is a conjunction of such bounds is taken apart; any other stays whole: its bounds
alone would say something else.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import date
from typing import Any

from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.kill_matrix import KillMatrix
from scaloft_fi.analysis.margin import Margin, Scale, lowest, margins, whens
from scaloft_fi.analysis.roster import Roster, by_field, plain
from scaloft_fi.analysis.score import MutantScore, Score
from scaloft_fi.analysis.suite import interactions, minimal_suite, orders, subsumption
from scaloft_fi.analysis.survivor import FAILING, PhasedFault, Tried, backgrounds
from scaloft_fi.campaign.store.held import nothing_to_show
from scaloft_fi.hazop.matrix import Matrix
from scaloft_fi.hazop.name import cell_of, parse, split_magnitude
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import TRIGGER, Kind, Requirement
from scaloft_fi.judge.stl import inside_always, tokenize
from scaloft_fi.study import Study
from scaloft_fi.verbs.margin import cell_margins, margin_text
from scaloft_fi.verbs.snapshot import NONE, Stale, snapshot
from scaloft_fi.verbs.survivors import short_units, survivors


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


_FOR = re.compile(r"historically \[ 0 : (?P<seconds>[\d.]+) \] (?P<rest>\(.*\))")
_JOINED = {"or", "implies", "iff", "since", "->"}
"""Words that bind otherwise than `and`, which only brackets may separate from it here."""


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
    defined = dict(requirement.definitions)
    demands = _demands(inside_always(requirement.text) or "", defined)
    when = _bounds(requirement.trigger, defined) if requirement.trigger else []
    whole = demands is not None and when is not None
    return {
        "name": requirement.name,
        "demands": [asdict(bound) for bound in demands or ()] if whole else [],
        "when": [asdict(bound) for bound in when or ()] if whole else [],
    }


def _demands(text: str, defined: Mapping[str, str]) -> list[Bound] | None:
    limits: list[Bound] = []
    for part in _conjuncts(text):
        triggered = part.startswith(f"{TRIGGER} implies ")
        demanded = part.removeprefix(f"{TRIGGER} implies ")
        bounds = _bounds(demanded, defined)
        if bounds is None or (triggered and len(bounds) > 1 and not demanded.startswith("(")):
            return None
        limits += [Bound(b.signal, b.sense, b.bound, b.for_s, triggered) for b in bounds]
    return limits


def _bounds(text: str, defined: Mapping[str, str], for_s: float | None = None) -> list[Bound] | None:
    """A conjunction as bounds; None where it is something else."""
    conjunction: list[Bound] = []
    for part in _conjuncts(text):
        lasting = _FOR.fullmatch(part)
        if part in defined:
            inner = _bounds(defined[part], defined, for_s)
        elif lasting and for_s is None:
            inner = _bounds(lasting["rest"], defined, float(lasting["seconds"]))
        else:
            inner = _bound(part, for_s)
        if inner is None:
            return None
        conjunction += inner
    return conjunction


def _bound(part: str, for_s: float | None) -> list[Bound] | None:
    match = COMPARISON.fullmatch(part.replace("- ", "-"))
    return [Bound(match["signal"], match["sense"], bound_of(match), for_s)] if match else None


def _conjuncts(text: str) -> Iterator[str]:
    """The parts that `and` joins outside all brackets, without the brackets around them.

    >>> list(_conjuncts("((trigger implies (a > 0 and b > 0)) and c > 1)"))
    ['trigger implies ( a > 0 and b > 0 )', 'c > 1']
    """
    tokens = _bare(tokenize(text))
    parts: list[list[str]] = [[]]
    outside = set()
    depth = 0
    for token in tokens:
        depth += (token == "(") - (token == ")")
        outside |= {token} if depth == 0 else set()
        if token == "and" and depth == 0:
            parts.append([])
        else:
            parts[-1].append(token)
    if len(parts) == 1 or outside & _JOINED:
        yield " ".join(tokens)
        return
    for part in parts:
        yield from _conjuncts(" ".join(part))


def _bare(tokens: list[str]) -> list[str]:
    """Without a pair of brackets around everything."""
    while tokens and tokens[0] == "(" and tokens[-1] == ")":
        depth = 0
        for place, token in enumerate(tokens):
            depth += (token == "(") - (token == ")")
            if depth == 0 and place < len(tokens) - 1:
                return tokens
        tokens = tokens[1:-1]
    return tokens


COMPARISON = re.compile(
    r"(?P<signal>[A-Za-z_]\w*)\s*(?:/\s*(?P<unit>\d+(?:\.\d+)?)\s*)?(?P<sense><=|>=|<|>)\s*(?P<bound>-?\d+(?:\.\d+)?)"
)


def limits(requirements: Iterable[Requirement], signals: Collection[str]) -> list[dict[str, Any]]:
    """Each comparison of one of `signals` with a number; role: `demands`, or `when` the requirement applies.

    A signal that is divided by a number first, as formulas that join units do, has its limit in its own unit.
    """
    limits: list[dict[str, Any]] = []
    for requirement in requirements:
        when = [requirement.trigger, *(text for _, text in requirement.definitions)]
        for role, texts in (("demands", [requirement.text]), ("when", when)):
            for signal, sense, bound in (entry for text in texts for entry in _comparisons(text)):
                entry = {
                    "signal": signal,
                    "sense": sense,
                    "bound": bound,
                    "role": role,
                    "requirement": requirement.name,
                }
                if signal in signals and entry not in limits:
                    limits.append(entry)
    return limits


def _comparisons(text: str) -> Iterator[tuple[str, str, float]]:
    for match in COMPARISON.finditer(text):
        yield match["signal"], match["sense"], bound_of(match)


def bound_of(match: re.Match[str]) -> float:
    """The bound of a comparison, in its signal's own unit."""
    return round(float(match["bound"]) * float(match["unit"] or 1), 9)


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
