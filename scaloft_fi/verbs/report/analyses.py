"""What the page is made from, its two matrices, and what follows: ladders, margins, limits, thresholds, survivors.

The matrices are the cells of the HAZOP study, and mutants x situations with their Karnaugh map.
Of requirements, only a formula that is a conjunction of bounds is taken apart; any other stays whole: its bounds alone
would say something else.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence, Set
from dataclasses import asdict, dataclass, field, replace
from datetime import date
from enum import StrEnum
from math import prod
from typing import Any

from scaloft_fi.analysis import kill_matrix as suites
from scaloft_fi.analysis.detection import Pool, Spending, State
from scaloft_fi.analysis.margin import Margin, Scale, lowest, margins, whens
from scaloft_fi.analysis.roster import Ratio, Roster
from scaloft_fi.analysis.score import Kill, MutantScore, Result, Score, cover, term_text
from scaloft_fi.analysis.survivor import FAILING, Disposition, Judged, PhasedFault, backgrounds, judge
from scaloft_fi.campaign.seeking.finds import words_of
from scaloft_fi.hazop.matrix import Matrix, cell_of, class_of, parse, split_magnitude
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import TRIGGER, Kind, Requirement, comparisons
from scaloft_fi.judge.space import Point, Space
from scaloft_fi.judge.status import INVALID, Ruled, Rulings, Situations, Status
from scaloft_fi.judge.stl import COMPARATORS, SAMPLE_MS, Infix, Interval, Node, Prefix, Signal, tokenize
from scaloft_fi.judge.stl import parse as parse_formula
from scaloft_fi.registry import grouped
from scaloft_fi.sim.grid import Grid
from scaloft_fi.study import Study
from scaloft_fi.verbs.margin import cell_margins, margin_text
from scaloft_fi.verbs.report.flights import listed
from scaloft_fi.verbs.snapshot import NONE, Stale, snapshot
from scaloft_fi.verbs.verdict import short_units, survivors
from scaloft_fi.views.output import by_field, plain


@dataclass(frozen=True)
class Evidence:
    """Everything that the page is made from.

    Attributes:
        study: what was flown.
        campaign: its name, for commands.
        outcomes: those that the study still stands for; the flights that the page lists have their tracks.
        listed: situations and seeds whose flights the page lists; None = all.
        stale: flights that no longer count.
        owed: flights planned and not flown.
        fingerprint: of the platform that flew them, by name.
        today: by which dispositions expire; None = none does.
        spending: how the campaign spends alpha.
    """

    study: Study
    campaign: str
    outcomes: tuple[Outcome, ...]
    listed: Set[tuple[str, int]] | None = None
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
        pairs = listed(now.outcomes)
        return Evidence(
            study=now.study,
            campaign=now.name,
            outcomes=now.with_tracks(now.outcomes, lambda one: (one.situation, one.seed) in pairs),
            listed=pairs,
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
    always = isinstance(tree, Prefix) and (tree.word, tree.interval) == ("always", None)
    demands = _bounds(tree.of, defined) if isinstance(tree, Prefix) and always else None
    when = _bounds(parse_formula(tokenize(requirement.trigger)), defined) if requirement.trigger else []
    if demands is None or when is None:
        demands = when = []
    return {"name": requirement.name, "demands": list(map(asdict, demands)), "when": list(map(asdict, when))}


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
    flown = {mutant.subject.id: mutant.kill_rate_flown.whole for mutant in mutants}
    most = {cell: max(map(flown.__getitem__, ids)) for cell, ids in grouped(flown, cell_of).items()}
    ids = {id_ for id_, situations in flown.items() if situations < most[cell_of(id_)]}
    return frozenset(ids.difference(roster.ids))


def analyses(evidence: Evidence, scored: Score, matrix: suites.KillMatrix) -> dict[str, Any]:
    """By section of the page; of the default mutants only, where ladders would count one fault several times.

    Args:
        evidence: what the page is made from.
        scored: the score of its flights.
        matrix: their kill matrix.
    """
    study, outcomes, roster = evidence.study, evidence.outcomes, evidence.study.roster
    counted = {row.id for row in matrix.mutants if row.counted}
    kills = {id_: keys for id_, keys in matrix.kills.items() if id_ in counted}
    listed = suites.interactions(matrix)
    units, campaign = short_units(study.requirements), evidence.campaign
    known = backgrounds(study.matrix, [row.id for row in matrix.mutants])
    return {
        "margins": margin_texts(scored, study.matrix),
        "ladders": ladders(scored, study.matrix, roster),
        "thresholds": thresholds(outcomes, scored, study.matrix, study.requirements),
        "whens": plain(whens(outcomes, scored)),
        "interactions": plain(listed),
        "orders": plain(suites.orders(listed, matrix.space)),
        "nist": {"shares": suites.NIST, "source": suites.NIST_SOURCE},
        "suite": plain(suites.minimal_suite(kills, [key for key, _ in matrix.space.situations])),
        "subsumption": plain(suites.subsumption(kills)),
        "survivors": plain(survivors(outcomes, scored, matrix, known, units, campaign, study.finds)),
    }


def margin_texts(scored: Score, cells: Matrix) -> dict[str, str]:
    """The margin of each cell that has one; faults without an order have a verdict and no margin."""
    by_cell = cell_margins(scored, cells).items()
    texts = {cell: "; ".join(one.text for one in listed if one.margin.known) for cell, listed in by_cell}
    return {cell: text for cell, text in texts.items() if text}


def ladders(scored: Score, cells: Matrix, roster: Roster) -> list[dict[str, Any]]:
    """Per cell flown with more than one magnitude its rungs from mild to strong; shifted phases are left out.

    A magnitude that a search flew is left out: its share would be one of situations chosen by their kills.
    """
    order, left_out = by_ladder(cells, roster), searched(scored.mutants, roster)
    rungs = [one for one in scored.mutants if one.subject.magnitude and "#" not in one.id and one.id not in left_out]
    by_cell = grouped(sorted(rungs, key=lambda one: order(one.id)), lambda one: cell_of(one.id))

    def rung(mutant: MutantScore) -> dict[str, Any]:
        told = by_field(mutant.subject, "id", "magnitude") | by_field(mutant, "verdict", "kill_rate")
        return told | {"default": roster.counts(mutant.subject)}

    several = [cell.name for cell in cells if len(by_cell[cell.name]) > 1]
    return [{"cell": name, "rungs": list(map(rung, by_cell[name]))} for name in several]


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
        **by_field(fault, "cell", "unit"),
        "worse": known[0].scale.sign if known else 1,
        "least": margin_text(least) if least else "",
        "situations_flown": len(listed),
        "against": against,
        "situations": [_situation(margin, against) for margin in known],
    }


def _situation(margin: Margin, against: Sequence[str]) -> dict[str, Any]:
    (key,) = margin.situations
    at = {tried.magnitude: tried for tried in margin.tried}
    survivor, strong = (None if end is None else at.get(end) for end in (margin.survives, margin.end))
    mild, harsh = (dict(tried.rho) if tried else {} for tried in (survivor, strong))
    return {
        "key": key,
        "margin": margin_text(margin),
        "survives": finite(margin.survives),
        "seen": finite(margin.seen),
        "kills": finite(margin.kills),
        "by": list(strong.requirements) if strong else [],
        "rho": {name: [finite(mild.get(name)), finite(harsh.get(name))] for name in against},
        "again": [finite(magnitude) for magnitude in margin.again],
        "flown": [finite(magnitude) for magnitude in sorted(at, key=margin.scale.strength)],
    }


def finite(value: float | None) -> float | str | None:
    """A number of JSON, which has no infinite ones: those are texts.

    >>> finite(0.5), finite(math.inf), finite(None)
    (0.5, 'inf', None)
    """
    return value if value is None or math.isfinite(value) else f"{value:g}"


LEAST_AXES = 2


def folding(space: Space) -> dict[str, Any]:
    """The axes that run down and across with the levels along each side, and where each situation lies.

    Returns:
        `reason`: why there is no map, in sentences, empty where there is one; then `down` and `across`, indices of
        axes; `rows` and `columns`, per place along that side a level of each of its axes; `cyclic`, whether the first
        and the last row are neighbours, and the same of columns; `keys`, (rows, columns) keys of situations, null
        where the grid has none.
    """
    if reason := _reason(space):
        return {"reason": reason}
    folded = suites.fold(space)

    def levels(axes: Sequence[int], points: Iterable[Point]) -> list[list[int]]:
        return [[space.values[at].index(one) for at, one in zip(axes, point, strict=True)] for point in points]

    return {
        "reason": "",
        "down": list(folded.down),
        "across": list(folded.across),
        "rows": levels(folded.down, folded.rows),
        "columns": levels(folded.across, folded.columns),
        "cyclic": [suites.cyclic(folded.rows), suites.cyclic(folded.columns)],
        "keys": [list(keys) for keys in folded.keys],
    }


def _reason(space: Space) -> str:
    """Why the page has no map of this grid; empty where it has one."""
    cells = prod(len(values) for values in space.values)
    if len(space.axes) < LEAST_AXES:
        return f"A Karnaugh map needs {LEAST_AXES} axes or more; this grid has {len(space.axes)}."
    if cells > suites.MOST_CELLS:
        return f"A Karnaugh map of {cells} situations could not be read; at most {suites.MOST_CELLS} are drawn."
    return ""


def terms(space: Space, row: suites.KillRow) -> list[dict[str, Any]]:
    """The terms of a mutant's condition where its grid has a map: `levels` has those that it admits, for each axis."""
    if _reason(space):
        return []
    return [
        {
            "levels": [sorted(map(values.index, kept)) for values, kept in zip(space.values, term, strict=True)],
            "words": term_text(space, term) or "everywhere",
        }
        for term in cover(space, row.killing, row.surviving)
    ]


STEPS = (1.0, 0.1, 0.001)
"""Parts of alpha; the p of a surer detection is at most the smaller ones."""
DIGITS = 3
"""Significant digits of the printed steps."""


def steps(alpha: float) -> list[float]:
    """The largest p of each step.

    >>> steps(0.01)
    [0.01, 0.001, 1e-05]
    """
    return [float(f"{alpha * part:.{DIGITS}g}") for part in STEPS]


def certainty(mutant: MutantScore, alpha: float) -> int:
    """How many steps the smallest p of the safety requirements that detect a mutant reaches; 0 where none does."""
    p = min((mutant.safety.p[name] for name in mutant.safety.by), default=None)
    return 0 if p is None else max(1, sum(p <= step for step in steps(alpha)))


def accepted(scored: Score, roster: Roster, known: Iterable[Disposition], today: date | None) -> dict[str, Any]:
    """Every counted survivor and every disposition with how it stands.

    Args:
        scored: of the campaign.
        roster: says which mutants count.
        known: the dispositions of the study.
        today: by which last days are judged; None = none is, so that the page never depends on a clock.
    """
    judged = judge(scored, roster, known, today)
    return {"today": today.isoformat() if today else None, "judged": [_standing(one) for one in judged]}


def _standing(judged: Judged) -> dict[str, Any]:
    disposition = judged.disposition
    entry = by_field(judged, "mutant", "state", "surviving")
    if disposition is None:
        return entry
    return entry | {
        **by_field(disposition, "owner", "reason", "situations"),
        "until": disposition.expires.isoformat(),
        "unnamed": [key for key in judged.surviving if disposition.situations and key not in disposition.situations],
    }


class Sign(StrEnum):
    """What a cell of the kill matrix shows; the first that fits."""

    NOT_FLOWN = "not_flown"
    """No flight that counts."""
    KILL = "kill"
    """A steady pair in which most flights of a detected mutant violate."""
    NOT_REACHED = "not_reached"
    """The seam carried no sample."""
    NOT_INFECTED = "not_infected"
    """No sample was changed."""
    MASKED = "masked"
    """Samples were changed, the drone flew the same to the bit."""
    SEEN = "seen"
    """A requirement that tests the fault, or may do so, is violated, and that makes no kill."""
    TESTED = "tested"
    """Put to the test, and nothing was seen."""
    NO_TEST = "no_test"
    """No safety requirement is steady here, so nothing is tested."""


_STOPPED = {status: Sign(status) for status in (Status.NOT_REACHED, Status.NOT_INFECTED, Status.MASKED)}


def seen_in(entry: suites.KillEntry, pool: Pool) -> tuple[str, ...]:
    """Safety requirements that are violated and test the fault; where no pool says what tests, those of any flight."""
    if entry.tested or entry.state != Status.REVEALED:
        return entry.seen
    pairs = [pool.pairs.get((entry.situation, name)) for name, _ in entry.violated]
    return tuple(p.requirement for p in pairs if p and p.kind is Kind.SAFETY and p.state is State.UNKNOWN)


def sign_of(entry: suites.KillEntry, seen: Collection[str]) -> Sign:
    """The sign of a mutant in a situation where these requirements are `seen_in` it."""
    if not entry.flown:
        return Sign.NOT_FLOWN
    if entry.kills:
        return Sign.KILL
    if stopped := _STOPPED.get(Status(entry.state)):
        return stopped
    if seen:
        return Sign.SEEN
    return Sign.TESTED if entry.tested else Sign.NO_TEST


def opening(flights: Sequence[Ruled], wanted: Iterable[str]) -> int:
    """The seed of the flight to show: the lowest one that violates what is `wanted` beside a baseline that holds it.

    Args:
        flights: of a mutant in a situation, at least one, in the order of their seeds.
        wanted: requirements, the most telling first; a flight that violates one whatever its baseline does is next
            best, then the first that counts.
    """
    counting = [one for one in flights if one.ruling is not INVALID] or list(flights)
    for name in wanted:
        violating = [one for one in counting if name in one.ruling.violated]
        revealing = [one for one in violating if name in (*one.ruling.revealed, *one.ruling.operability_revealed)]
        if violating:
            return (revealing or violating)[0].seed
    return counting[0].seed


EVERY_VALUE_BENIGN = "every value benign"
SIGNS = [sign.value for sign in Sign]
KEPT = (
    *("id", "guideword", "parameter", "magnitude", "severity", "status", "verdict", "firm"),
    *("kill_rate", "kill_rate_flown", "decided_at"),
)
"""What the page takes over from the score's JSON on a mutant."""


def situations(space: Space, grid: Grid) -> list[dict[str, Any]]:
    """Every situation in Gray-code order: each differs from the one before in one axis by one step.

    `words` has the value of each axis, `name` those that are not benign.
    """
    return [
        {
            "key": key,
            "levels": [space.values[axis].index(value) for axis, value in enumerate(space.point[key])],
            "words": list(space.words_of(key)),
            "name": key if space.of_tests else ", ".join(words_of(grid.situation(key), grid)) or EVERY_VALUE_BENIGN,
            "aliases": list(grid.aliases_of(grid.situation(key))),
        }
        for key in suites.gray_order(space)
    ]


def axes(grid: Grid) -> list[dict[str, Any]]:
    """The axes with the words for their values, the benign one first."""
    words = {axis.id: [value.title for value in axis.values] for axis in grid.axes}
    return [by_field(axis, "id", "title", "category") | {"words": words[axis.id]} for axis in grid.axes]


def cells(matrix: Matrix, flown: Iterable[str]) -> list[dict[str, Any]]:
    """Every entry of the deviation matrix with its mutants that were flown, the default first named."""
    by_cell = grouped(flown, cell_of)
    return [
        {
            **by_field(cell, "name", "guideword", "parameter", "status", "deviation", "causes", "effect"),
            **by_field(cell, "requirements", "reason", "predicted"),
            "severity": class_of(matrix.severities.get(cell.name)),
            "expected": [fault.expected.reason for fault in cell.faults if fault.expected],
            "default": cell.default_id if cell.faults else "",
            "mutants": by_cell[cell.name],
        }
        for cell in matrix
    ]


def mutants(
    scored: Score,
    matrix: suites.KillMatrix,
    rulings: Rulings,
    records: Iterable[Mapping[str, Any]],
    roster: Roster,
    keys: Sequence[str],
    order: Callable[[str], Any],
) -> list[dict[str, Any]]:
    """Every mutant and control flown.

    Args:
        scored: of the campaign.
        matrix: its kill matrix.
        rulings: of its flights.
        records: the mutants and controls of the score's JSON.
        roster: says which mutants count.
        keys: of the situations, in the order of `results`.
        order: of ids.
    """
    known = {entry["id"]: entry for entry in records}
    extra = searched(scored.mutants, roster)
    described = []
    for mutant in sorted((*scored.mutants, *scored.controls), key=lambda one: order(one.subject.id)):
        id_, flights = mutant.subject.id, rulings.mutants[mutant.subject]
        row = matrix.row[id_]
        entries = {entry.situation: entry for entry in row.entries}
        by_kind = (mutant.kills, mutant.operability_kills)  # of each kind the most violated first
        kills = [kill for own in by_kind for kill in sorted(own, key=lambda kill: -kill.violated / kill.flights)]
        results = {result.situation: result for result in mutant.results}
        described.append(
            {name: known[id_][name] for name in KEPT}
            | _mutant(mutant, roster, matrix.space)
            | {
                "certainty": certainty(mutant, scored.alpha),
                "kills": [_kill(kill, flights[kill.situation], scored.pool) for kill in kills],
                "searched": id_ in extra,
                "tests": _tests(mutant, scored.pool),
                "results": [_result(entries[key], results.get(key), flights, scored.pool) for key in keys],
                "terms": terms(matrix.space, row),
            }
        )
    return described


def _mutant(scored: MutantScore, roster: Roster, space: Space) -> dict[str, Any]:
    first = scored.first
    return {
        "cell": cell_of(scored.subject.id),
        "control": roster.is_control(scored.subject),
        "counts": roster.counts(scored.subject),
        "by": [*scored.safety.by, *scored.operability.by],
        "shows": list(scored.shown_by) if roster.is_control(scored.subject) else [],
        "condition": scored.condition(space),
        "same": scored.without_effect,
        "first": by_field(first, "requirement", "t_s", "situation", "seed") if first else None,
    }


def _kill(kill: Kill, flights: Sequence[Ruled], pool: Pool) -> dict[str, Any]:
    """A kill with the flight to open, which has it: its seed, when it violates the requirement, what it strikes."""
    seed = opening(flights, (kill.requirement,))
    own = (violation for one in flights if one.seed == seed for violation in one.violations)
    (violation,) = (one for one in own if one.requirement == kill.requirement)
    beside = pool.pairs[kill.situation, kill.requirement]
    return {
        **by_field(kill, "situation", "requirement"),
        "flights": plain(Ratio(kill.violated, kill.flights)),
        "baseline": plain(Ratio(beside.violated, beside.judged)),
        "seed": seed,
        **by_field(violation, "t_s", "struck"),
    }


def _tests(scored: MutantScore, pool: Pool) -> list[dict[str, Any]]:
    """Per requirement that puts the mutant to the test somewhere its p, and what was seen there.

    Returns:
        `kills`: situations with a kill, of those that test it; `flights`: of the mutant that violate, in these;
        `baseline`: of the pool that violate, of those judged, in these.
    """
    records, p = [], {**scored.safety.p, **scored.operability.p}
    for name in (*pool.requirements(Kind.SAFETY), *pool.requirements(Kind.OPERABILITY)):
        tests = [result for result in scored.results if name in (*result.steady, *result.steady_operability)]
        pairs = [pool.pairs[result.situation, name] for result in tests]
        kills = sum(name in (*result.kills, *result.operability_kills) for result in tests)
        violated = sum(dict(result.violated).get(name, 0) for result in tests)
        ratios = {
            "kills": Ratio(kills, len(tests)),
            "flights": Ratio(violated, sum(result.flown for result in tests)),
            "baseline": Ratio(sum(own.violated for own in pairs), sum(own.judged for own in pairs)),
        }
        if tests:
            records.append({"requirement": name, "p": p[name], **plain(ratios)})
    return records


def _result(entry: suites.KillEntry, result: Result | None, flights: Situations, pool: Pool) -> list[Any] | None:
    """Sign by its place in `SIGNS`, flights that count, seed to open, flights that violate each, by which it is a sign.

    Null where nothing was flown.
    """
    if entry.situation not in flights:
        return None
    violated = {name: count for name, count in entry.violated if (entry.situation, name) in pool.pairs}
    operability = result.operability_kills if result else ()
    seen = seen_in(entry, pool)
    seed = opening(flights[entry.situation], (*entry.kills, *operability, *seen, *violated))
    return [SIGNS.index(sign_of(entry, seen)), entry.flown, seed, violated, list(entry.kills or seen)]


def by_situation(scored: Score, roster: Roster, keys: Sequence[str]) -> list[dict[str, int]]:
    """Per situation the default mutants with a kill, of those that it puts to the test, and of those flown."""
    counted = [mutant for mutant in scored.mutants if roster.counts(mutant.subject)]
    here = ([result for mutant in counted for result in mutant.results if result.situation == key] for key in keys)
    return [
        {"killed": sum(bool(one.kills) for one in own), "tested": sum(one.tested for one in own), "flown": len(own)}
        for own in here
    ]
