"""A verdict in words: what it rests on, what would decide an open one, and the command to call next."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

from scaloft_fi.analysis.detection import LARGER, LEAST, State, Verdict
from scaloft_fi.analysis.score import MutantScore, Score
from scaloft_fi.analysis.survivor import Background, CampaignFacts, Case, Disposition, Loss
from scaloft_fi.campaign.store.archive import flown_in
from scaloft_fi.defaults import CAMPAIGN
from scaloft_fi.hazop.matrix import cell_of, class_of, worst_first
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Kind, Requirement
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Status
from scaloft_fi.output import STUDY_OPTION, Marked, Style, in_campaign, printable, styled, wrapped
from scaloft_fi.sim.grid import Break, Evidence, Find
from scaloft_fi.sim.situation import Situation
from scaloft_fi.study import NO_FINDS, KnownFinds, Study
from scaloft_fi.views.table import counted

if TYPE_CHECKING:
    from scaloft_fi.analysis.kill_matrix import KillMatrix

MOST_NAMED = 4
"""Of more mutants than these a command leaves out the names where `run` flies the same without."""


def command(
    campaign: str,
    mutants: Sequence[MutantScore],
    seeds: int,
    defaults: Collection[str] = (),
    grid: str = "",
    situations: int = 0,
    where: Collection[str] = (),
) -> str:
    """The `run` that flies these mutants, and no others; drawn numbers are of no grid, so their situations are named.

    So are a few situations of a grid that has more.

    Args:
        campaign: its name.
        mutants: those to fly.
        seeds: of each.
        defaults: ids of the mutants that `run` flies when none is named; exactly these need no name.
        grid: the further grid of a campaign that is still to be made.
        situations: number of situations of the grid.
        where: in which situations; by default in those that they flew.
    """
    words = [f"scaloft-fi run{in_campaign(flown_in(campaign))}", *([f"--grid {grid}"] if grid else [])]
    ids = [mutant.subject.id for mutant in mutants]
    if len(ids) <= MOST_NAMED or set(ids) != set(defaults):
        words += [f"--mutant {id_}" for id_ in ids]
    flown = dict.fromkeys(where or (result.situation for mutant in mutants for result in mutant.results))
    drawn = any((situation := Situation.parse(key)) and situation.numbers for key in flown)
    if drawn or (len(flown) <= MOST_NAMED and len(flown) < situations):
        words += [f"--situation {key}" for key in flown]
    if seeds > 1:
        words.append(f"--seeds {seeds}")
    return " ".join(words)


SIGNS = {
    "●": ("shown", Style.GOOD),
    "○": ("shown, not firmly", Style.GOOD),
    "–": ("not shown", Style.BAD),  # noqa: RUF001 - a dash is a sign
    "?": ("undecided", Style.DOUBT),
    "·": ("never put to the test", Style.STRONG),
}
"""What the sign of a cell says of its default mutant, and its style."""
_SIGN = {Verdict.NOT_DETECTED: "–", Verdict.UNDECIDED: "?", Verdict.NOT_TESTED: "·"}  # noqa: RUF001


def signs_of(scored: Score) -> dict[str, str]:
    """The sign of each cell of which the default mutant was flown, by the cell's name."""
    return {cell_of(mutant.id): _SIGN.get(mutant.verdict, "○●"[mutant.firm]) for mutant in scored.counted}


def with_legend(grid: str, signs: Mapping[str, str], width: int, *, marked: bool) -> str:
    """A grid of signs, coloured if wanted, above what those of them say that a cell has."""
    told = "  ".join(f"{sign} {words}" for sign, (words, _) in SIGNS.items() if sign in signs.values())
    text = printable(f"{grid}\n{wrapped(told, width)}")
    return Marked("".join(styled(one, SIGNS[one][1]) if one in SIGNS else one for one in text)) if marked else text


def next_step(scored: Score, study: Study, campaign: str, invalid: Sequence[str] = ()) -> str:
    """The command that is the most useful now, as every screen of a campaign says; the arguments of `answers`."""
    if invalid:
        return "get a valid score: mend what makes it invalid, then the same run asks the gates again."
    faults, survivors = scored.faults, f"`scaloft-fi kills{in_campaign(campaign)} --show survivors`"
    finds, defaults, every = study.finds, study.roster.defaults.values(), len(study.grid.situations)
    if study.tests_of:
        if faults and all(mutant.detected for mutant in faults):
            return "nothing: every fault is shown."
        return f"write a test; `{study.again}{in_campaign(campaign)}` lists below its score what each test has to see."
    if scored.lacking:
        seeds = max((result.flown for mutant in faults for result in mutant.results), default=1)
        run = command(campaign, faults, seeds, defaults, "", every, scored.lacking)
        lacking, flown = len(scored.lacking), len({result.situation for one in faults for result in one.results})
        missing = f"`{run}` flies the baseline pool that is missing in {counted(lacking, 'situation')}"
        return missing + _beyond(lacking, every, flown) + "."
    missed_first = sorted(faults, key=lambda mutant: mutant.verdict is not Verdict.NOT_DETECTED)
    worst = worst_first(missed_first, lambda mutant: mutant.severity)
    found = [(mutant.subject.id, find) for mutant in worst if (find := next_find(mutant, finds))]
    if found:
        (mutant, find), *others = found
        run = f"`{flies(find, mutant, finds, campaign, study.space.grid)}`"
        shows = f"fly where a search found that {mutant} {effect(find.shows[mutant])}: {run}."
        return f"{shows}  {counted(len(others), 'other')}: {survivors}." if others else shows
    undecided = [mutant for mutant in faults if mutant.verdict is Verdict.UNDECIDED]
    looks = [mutant for mutant in undecided if mutant.safety.needed and not mutant.safety.anew]
    if looks:
        flown = len({result.situation for mutant in looks for result in mutant.results})
        run = command(campaign, looks, max(mutant.safety.needed or 0 for mutant in looks), defaults, "", every)
        decides = f"`{run}` would decide {len(looks)} of the {len(undecided)} undecided"
        return decides + _beyond(flown, every, flown) + "."
    if any(not mutant.detected for mutant in faults):
        return f"{survivors} says of each fault not shown where it stopped, and what to change."
    if faults:
        margin = f"`scaloft-fi margin{in_campaign(flown_in(campaign))} {faults[0].subject.id}`"
        return f"{margin} finds the smallest magnitude that is still shown."
    option = STUDY_OPTION.get()
    return f"`scaloft-fi run{option} --mutant ID` flies a mutant; `scaloft-fi mutants{option}` lists them."


def _beyond(needed: int, every: int, flown: int) -> str:
    """That a command flies more situations than it needs, because it names none of them."""
    more = f"; it flies all {every} situations, of which {flown} were flown"
    return more if MOST_NAMED < needed < every else ""


NO_POOL = (
    f"no situation in which a mutant changes a sample has {LEAST} baseline flights to decide by; `scaloft-fi run` with "
    "the same mutants flies them"
)
"""Why a campaign without a pool has no verdict, and what flies one."""


def verdict(mutant: MutantScore, lacking: Collection[str]) -> str:
    """The verdict by safety requirements and what it rests on: `detected: killed in 8 of 23 situations ...`.

    Args:
        mutant: of a score.
        lacking: situations where the pool has too few flights, as the score names them.
    """
    return f"{mutant.verdict.words}: {why(mutant, lacking)}"


def why(mutant: MutantScore, lacking: Collection[str]) -> str:
    """What the verdict rests on; detection by operability requirements behind it."""
    if mutant.verdict is Verdict.UNDECIDED:
        text = _undecided(mutant, lacking)
    elif mutant.detected:
        text = _detected(mutant)
    else:
        text = f"nothing seen in {_tests(mutant)}; {_unseen(mutant)}" if mutant.tested else _untested(mutant)
    return text + ("; by operability it is detected" if mutant.operability.detected else "")


def would_decide(mutant: MutantScore, lacking: Collection[str]) -> str:
    """What would decide an undecided mutant; empty for any other."""
    safety = mutant.safety
    if mutant.verdict is not Verdict.UNDECIDED:
        return ""
    if lacks_pool(mutant, lacking):
        return f"{LEAST} baseline flights in each situation"
    if safety.needed is None:
        return f"no number of seeds up to {LARGER[-1]}"
    return f"{safety.needed} seeds" + (" in a campaign of its own" if safety.anew else "")


def next_command(
    mutant: MutantScore, lacking: Collection[str], campaign: str, space: Space, finds: KnownFinds = NO_FINDS
) -> str:
    """What to call next for a mutant that is not detected: its find, else what would decide, else what is known.

    Args:
        mutant: the mutant.
        lacking: situations without a baseline pool.
        campaign: name of the campaign.
        space: the situations of its grid.
        finds: of the study.
    """
    find = next_find(mutant, finds)
    if find is not None:
        return flies(find, mutant.subject.id, finds, campaign, space.grid)
    if mutant.verdict is Verdict.UNDECIDED and lacks_pool(mutant, lacking):
        seeds = max((result.flown for result in mutant.results), default=1)
        return command(campaign, [mutant], seeds, situations=len(space.points))
    if mutant.safety.needed and not mutant.without_effect:
        return flies_seeds(mutant, campaign, space)
    return f"scaloft-fi kills{in_campaign(campaign)} {mutant.subject.id} --show survivors"


def flies_seeds(mutant: MutantScore, campaign: str, space: Space) -> str:
    """The command that flies as many seeds as would decide an undecided mutant; the arguments of `next_command`."""
    name, over = ("ANOTHER", space.grid) if mutant.safety.anew else (campaign, "")
    return command(name, [mutant], mutant.safety.needed or 1, grid=over, situations=len(space.points))


def lacks_pool(mutant: MutantScore, lacking: Collection[str]) -> bool:
    """Whether an undecided mutant changes samples in a situation where the pool has too few flights."""
    return not mutant.tested or any(result.infected and result.situation in lacking for result in mutant.results)


def _detected(mutant: MutantScore) -> str:
    firm = mutant.firmness.words if mutant.firmness else ""
    if mutant.kills:
        names = {kill.requirement for kill in mutant.kills}
        told = (f"{name} in {ratio.part} of {ratio.whole}" for name, ratio in mutant.requirements if name in names)
        by = ", ".join(told)
        return f"killed in {len(mutant.killing)} of {_tests(mutant)} ({by}); {firm}"
    by = ", ".join(f"{name} (p = {mutant.safety.p[name]:.2g})" for name in mutant.safety.by)
    seen = f"; seen in {len(mutant.seen_in)} of {_tests(mutant)}" if mutant.seen_in else ""
    return f"it violates {by} more often than chance explains, but nowhere in most of its flights{seen}; {firm}"


def _undecided(mutant: MutantScore, lacking: Collection[str]) -> str:
    decides = f"{would_decide(mutant, lacking)} would decide"
    if mutant.seen_in:
        names = " and ".join(dict.fromkeys(name for result in mutant.results for name in result.seen))
        rate = f"{len(mutant.seen_in)} of {_tests(mutant)}"
        p = f"p = {min(mutant.safety.p.values()):.2g}"
        return f"it violates {names} in {rate}, which chance may explain ({p}); {decides}, if this goes on"
    if mutant.tested:
        same = "; samples changed, no flight did" if mutant.without_effect else ""
        nothing = f"nothing seen in {_tests(mutant)}{same}"
        if lacks_pool(mutant, lacking):
            return f"{nothing}, and others have too few baseline flights to tell; {decides}"
        return f"{nothing}, with too few flights to tell; {decides}"
    counts = dict(mutant.statuses)
    revealed, flown = counts.get(Status.REVEALED, 0), sum(result.flown for result in mutant.results)
    seen = f"{revealed} of its {flown} flights violate a safety requirement that the baseline beside them holds"
    return f"too few baseline flights to tell; {seen}; {decides}"


def _unseen(mutant: MutantScore) -> str:
    if mutant.status is Status.MASKED:
        return "samples changed, no flight did"
    if {Status.REVEALED, Status.BASELINE_RED} & dict(mutant.statuses).keys():
        return "violations only where the unmutated drone does not hold the requirement steadily"
    return "the flights that changed violate no safety requirement"


def _untested(mutant: MutantScore) -> str:
    if not mutant.flown:
        return "the harness failed in every flight"
    if mutant.infected:
        return "it changes no sample where the unmutated drone holds a safety requirement steadily"
    if any(result.reached for result in mutant.results):
        return "it changes no sample in any situation flown"
    return "no sample crosses the patched interface in any situation flown"


def _tests(mutant: MutantScore) -> str:
    count = mutant.kill_rate.whole
    return f"{count} situation that tests it" if count == 1 else f"{count} situations that test it"


def next_find(mutant: MutantScore, finds: KnownFinds) -> Find | None:
    """The find to fly next for a mutant; every text that says what to do next asks here.

    None for a mutant that is detected, that has no flight that counts, or whose finds were flown in this campaign.
    """
    if mutant.detected or not mutant.flown:
        return None
    return next((find for find in finds.of(mutant.subject.id) if not _flown(mutant, find)), None)


def flown_in_vain(mutant: MutantScore, finds: KnownFinds) -> tuple[Find, ...]:
    """The finds of a mutant that were flown in this campaign with as many seeds, and did not show it."""
    return () if mutant.detected else tuple(find for find in finds.of(mutant.subject.id) if _flown(mutant, find))


def _flown(mutant: MutantScore, find: Find) -> bool:
    seeds = find.shows[mutant.subject.id].flights
    return any(result.situation == find.situation and result.flown >= seeds for result in mutant.results)


def words(find: Find | Break) -> str:
    """The situation of a find or a break in words.

    >>> words(Find("shows-A", "T0H2Cs=0.8", ("human walks", "cruise speed 0.8 m/s"), "A", {}, 0))
    'human walks, cruise speed 0.8 m/s'
    """
    return ", ".join(find.words) or "every value benign"


def effect(evidence: Evidence) -> str:
    """What the mutant does there: `violates SR2 and strikes person`."""
    return f"violates {evidence.requirement}" + f" and strikes {evidence.struck}" * bool(evidence.struck)


def facts(find: Find, mutant: str) -> str:
    """The find in a sentence, with its evidence."""
    shown = find.shows[mutant]
    told = (
        f"a search found a situation that shows it, {find.name} ({words(find)}): it {effect(shown)} there, in "
        f"{shown.violated} of {shown.flights} flights (p = {shown.p:.2g}); the unmutated drone holds "
        f"{shown.requirement} in {shown.held} of {shown.baselines} by more than its spread."
    )
    if shown.again is None:
        return f"{told}  It is not replicated yet (`scaloft-fi seek --replicate`)."
    again = f"{shown.again.violated} of {shown.again.flights} (p = {shown.again.p:.2g})"
    return f"{told}  On fresh seeds it held again: {again}."


def flies(find: Find, mutant: str, finds: KnownFinds, campaign: str, grid: str = "") -> str:
    """The command that flies a find for a mutant.

    Args:
        find: one of `finds`.
        mutant: id of a mutant that it shows.
        finds: of the study.
        campaign: name of the campaign that asks; one over the grid of the finds gets the flights itself.
        grid: name of its grid, where that is a further grid of the study.
    """
    where = in_campaign(flown_in(campaign)) if grid == finds.grid != campaign else in_campaign(CAMPAIGN)
    named = f"--mutant {mutant} --situation {shlex.quote(find.name)}"
    return f"scaloft-fi run --grid {finds.grid}{where} {named} --seeds {find.shows[mutant].flights}"


class Next(StrEnum):
    """What would make a survivor say something."""

    REPEAT = "repeat"
    FIND = "find"
    """The situation that a search found for it, which is to be flown."""
    POOL = "pool"
    """The baselines that are lacking to decide."""
    SEEDS = "seeds"
    SITUATION = "situation"
    MAGNITUDE = "magnitude"
    ORACLE = "oracle"
    OPERABILITY = "operability"
    """Nothing: an operability requirement detects it, and its cell puts no other at risk."""
    TEST = "test"
    """Of a campaign of one's own tests: another test."""
    EXPECTED = "expected"
    """The study declares, with a reason, that it alters nothing in this grid."""


def acceptance(disposition: Disposition) -> str:
    """Who accepted a survivor, where, until when and why."""
    where = f" in {', '.join(disposition.situations)}" if disposition.situations else ""
    until = disposition.expires.isoformat()
    return f"accepted{where} by {disposition.owner} until {until}: {disposition.reason}"


def sentence(reason: str) -> str:
    """A reason as a sentence of a page."""
    return f"{reason[0].upper()}{reason[1:]}."


NAMED = 3
"""How many situations a sentence names before it counts the rest."""


def rates(case: Case) -> str:
    """What was seen of an undecided mutant, and why that does not decide."""
    safety, sentences = case.score.safety, []
    for name in case.campaign.safety:
        tests = [result for result in case.score.results if name in result.steady]
        violated = {result.situation: count for result in tests if (count := dict(result.violated).get(name))}
        if violated:
            rate = f"{sum(violated.values())} of {sum(result.flown for result in tests)} flights where {name} is steady"
            chance = f"chance may explain that (p = {safety.p[name]:.2g}, alpha {safety.share:g})"
            sentences.append(f"{rate} violate it, in {some(list(violated))}: {chance}.")
    nothing = f"no steady requirement is violated in {counted(len(case.tested), 'flight')}"
    return " ".join(sentences) or f"{nothing}: too few to decide, whatever they do."


def seeds(case: Case) -> str:
    """How many seeds would decide an undecided mutant, with the command; empty for any other."""
    decides = would_decide(case.score, case.lacking)
    if not decides:
        return ""
    rate = "At that rate" if case.score.seen_in else "If every flight violated,"
    if case.score.safety.needed is None:
        return f"{rate} {decides} would decide: add a situation where it shows more often."
    flies = flies_seeds(case.score, case.campaign.name, case.campaign.space)
    return f"{rate} {decides} would decide: `{flies}`."


def only_unsteady(case: Case) -> str:
    """Where flights violate what the baselines of their seeds hold, if none of it is steady; empty if none do."""
    revealing = [flight for flight in case.flights if flight.revealed]
    names = dict.fromkeys(name for flight in revealing for name in flight.revealed)
    where = {name: {one.outcome.situation for one in revealing if name in one.revealed} for name in names}
    unsteady = [f"{name} is {states_in_words(case.campaign.states(name, keys))}" for name, keys in where.items()]
    return f"{violate(len(revealing))}, but only where that is not steady: {'; '.join(unsteady)}." if unsteady else ""


def path(case: Case) -> str:
    """How far it takes the drone off its path."""
    if case.off_path_m is None:
        return "how far the drone flies off its path is not known: no trajectory."
    return f"it takes the drone at most {case.off_path_m:.2f} m off its path."


def violate(flights: int) -> str:
    """How many flights violate a safety requirement, each beside its own baseline."""
    if flights == 1:
        return "1 flight violates what the baseline of its seed holds"
    return f"{flights or 'no'} flights violate what the baselines of their seeds hold"


def untested(case: Case) -> str:
    """Why no flight could have violated what the cell puts at risk; empty when one could."""
    campaign = case.campaign
    at_risk = [name for name in case.background.at_risk if name in campaign.safety]
    states = {name: campaign.states(name, case.infected) for name in at_risk}
    if not at_risk or any(State.STEADY in counts for counts in states.values()):
        return ""
    sentences = []
    for name, counts in states.items():
        steady = {key for key in campaign.pool.flown if campaign.pool.states.get((key, name)) is State.STEADY}
        where = campaign.where(steady.__contains__, campaign.pool.flown)
        there = f"{name}, which the cell puts at risk, is {states_in_words(counts)} where it infects"
        sentences.append(f"{there}; it is steady {in_(where)}.")
    return " ".join(sentences)


def margin(case: Case) -> str:
    """As in: SR1 fell from 0.31 to 0.12 m in T0O0W0D0H1 (61 % of the margin)."""
    loss = case.loss
    if loss is None:
        return ""
    if loss.share <= 0:
        return "No margin fell."
    unit = case.campaign.units.get(loss.requirement, "")
    at = f"in {loss.situation}" + (f", seed {loss.seed}" if loss.seed else "")
    change = f"from {loss.baseline:.2g} to {loss.flown:.2g}{' ' * bool(unit)}{unit}"
    return f"{loss.requirement} fell {change} {at} ({100 * loss.share:.0f} % of the margin)."


def left(case: Case) -> str:
    """What of the grid is left to fly."""
    space = case.campaign.space
    count = len(space.points) - len({space.point[key] for key in case.flown if key in space.point})
    if not count:
        return "the whole grid was flown: add a situation."
    return f"{counted(count, 'situation')} of the grid {'was' if count == 1 else 'were'} not flown."


def larger(case: Case) -> str:
    """What to do where a larger fault may be detected."""
    searches = f"`scaloft-fi margin{in_campaign(flown_in(case.campaign.name))} {case.row.id}` searches"
    return f"The next rung is {case.background.stronger[0]}; {searches} for the least magnitude that is killed."


def states_in_words(states: Mapping[State, int]) -> str:
    """As in: `vacuous in 1 and red in 2 situations`."""
    present = {state: states[state] for state in State if states.get(state)}
    last = next(reversed(present.values()), 0)
    told = " and ".join(f"{state.value} in {count}" for state, count in present.items())
    return f"{told} situation{'s' * (last != 1)}"


def in_vain(case: Case, finds: Sequence[Find]) -> str:
    """That finds were flown and did not show it; the study has changed since, or other situations drown them."""
    names = " and ".join(find.name for find in finds)
    flown = f"{names} {'was' if len(finds) == 1 else 'were'} flown here with as many seeds"
    seeks = f"`scaloft-fi seek{STUDY_OPTION.get()} {case.row.id}`"
    return f"{flown}, and it is not detected all the same: {seeks} seeks another situation."


def in_(where: str) -> str:
    """As in: `in human & light`, `everywhere`."""
    return where if where in ("everywhere", "nowhere", "wherever tested") else f"in {where}"


def some(keys: Sequence[str]) -> str:
    """The first of some names, and how many others there are."""
    rest = f" and {len(keys) - NAMED} more" if len(keys) > NAMED else ""
    return ", ".join(keys[:NAMED]) + rest


NEAR = 0.5
"""A flight that lost half its baseline's margin is a near miss: a somewhat larger fault may be detected."""
ASTRAY_M = 0.5
"""A flight is far off its baseline's path from here [m]: as near as the study asks a waypoint to be passed."""
SILENT = "Judge whether that is a hazard; if it is, a requirement is missing."


class Stage(StrEnum):
    """Where a survivor stopped."""

    HARNESS = "harness"
    """No flight of it counts."""
    REACH = "reach"
    """The seam carried no sample."""
    INFECT = "infect"
    """No sample was changed."""
    PROPAGATE = "propagate"
    """Samples were changed, the drone flew the same to the bit."""
    REVEAL = "reveal"
    """The drone flew otherwise, and violated no safety requirement more often than chance explains."""


_STAGE = dict.fromkeys(Status, Stage.REVEAL) | {
    Status.INVALID: Stage.HARNESS,
    Status.NOT_REACHED: Stage.REACH,
    Status.NOT_INFECTED: Stage.INFECT,
    Status.MASKED: Stage.PROPAGATE,
}


@dataclass(frozen=True)
class Survivor:
    """A mutant that is not detected.

    Attributes:
        mutant: id of the mutant.
        verdict: on the mutant; never `detected`.
        stage: where it stopped.
        next: what to change.
        why: the facts, and what to do, in a few sentences.
        loss: where it took most of a baseline's margin in a steady pair; null: it cannot be measured.
        off_path_m: how far it was off its baseline's path at the most [m]; null: no flight that put it to the test has
            a trajectory.
        find: name of the find that is to be flown; empty without one.
        severity: class of severity, one of the study's own; in no ratio; null: it has none.
    """

    mutant: str
    verdict: Verdict
    stage: Stage
    next: Next
    why: str
    loss: Loss | None = None
    off_path_m: float | None = None
    find: str = ""
    severity: str | None = None


def short_units(requirements: Iterable[Requirement]) -> dict[str, str]:
    """The unit of each requirement's robustness, without what the study says beside it."""
    return {requirement.name: requirement.unit.split(" (")[0].split(";")[0] for requirement in requirements}


def survivors(
    outcomes: Iterable[Outcome],
    scored: Score,
    matrix: KillMatrix,
    backgrounds: Mapping[str, Background],
    units: Mapping[str, str] | None = None,
    name: str = CAMPAIGN,
    finds: KnownFinds = NO_FINDS,
) -> tuple[Survivor, ...]:
    """Every mutant that is not detected, the worst class first, by stage, then in the matrix's order; no controls.

    Args:
        outcomes: of the campaign, with the trajectories of a seed if distances off the path are wanted.
        scored: their score.
        matrix: its kill matrix, or those rows of it that are asked for.
        backgrounds: of every mutant in it.
        units: of the requirements' robustness, by name.
        name: of the campaign.
        finds: of the study.
    """
    campaign = CampaignFacts.of(outcomes, scored, matrix, backgrounds, units or {}, name)
    cases = [Case(campaign, row, backgrounds[row.id]) for row in matrix.mutants if row.verdict is not Verdict.DETECTED]
    cases.sort(key=lambda case: list(Stage).index(_STAGE[case.row.status]))
    return tuple(_survivor(case, scored, finds) for case in worst_first(cases, lambda case: case.score.severity))


def _survivor(case: Case, scored: Score, finds: KnownFinds) -> Survivor:
    steps, told = advice(case.score, scored, case.background, finds)
    find = next_find(case.score, finds)
    sentences = [sentence[:1].upper() + sentence[1:] for sentence in told(case) if sentence]
    if find is None and (vain := flown_in_vain(case.score, finds)):
        sentences.append(in_vain(case, vain))
    return Survivor(
        mutant=case.row.id,
        verdict=case.row.verdict,
        stage=_STAGE[case.row.status],
        next=steps[-1] if _astray(case) else steps[0],
        why=" ".join(sentences),
        loss=case.loss,
        off_path_m=case.off_path_m,
        find=find.name if find else "",
        severity=class_of(case.score.severity) or None,
    )


class Advice(NamedTuple):
    """What to do about a mutant that is not detected.

    Attributes:
        steps: the step that its score asks for; of two, its flights say which.
        told: the sentences that say why, and what to do, from its flights.
    """

    steps: tuple[Next, ...]
    told: Callable[[Case], Iterable[str]]


def advice(mutant: MutantScore, scored: Score, background: Background | None, finds: KnownFinds = NO_FINDS) -> Advice:
    """What to do about a mutant.

    Args:
        mutant: not detected.
        scored: of the campaign.
        background: what the study knows of the mutant; None where it knows nothing.
        finds: of the study.
    """
    known = background or Background("")
    stronger = Next.MAGNITUDE if known.stronger else Next.SITUATION
    if find := next_find(mutant, finds):
        return Advice((Next.FIND,), lambda case: _with_find(case, find, finds))
    if not mutant.flown:
        return Advice((Next.REPEAT,), lambda _: ["no flight of it counts: fly it again."])
    if known.expected and not mutant.infected:
        return Advice((Next.EXPECTED,), lambda _: [f"declared beforehand: {known.expected}."])
    if scored.of_tests:
        return Advice((Next.TEST,), lambda case: [*([rates(case)] if mutant.seen_in else []), _another_test(case)])
    if not any(result.reached for result in mutant.results):
        return Advice((Next.SITUATION,), _not_reached)
    if not mutant.infected:
        infecting = {one.subject.id for one in scored.mutants if one.infected}
        larger = next((id_ for id_ in known.stronger if id_ in infecting), "")
        small = f"it changes no sample, {larger} does: too small to be seen."
        return Advice((Next.MAGNITUDE,), lambda _: [small]) if larger else Advice((Next.SITUATION,), _not_infected)
    if any(result.infected and result.situation in scored.lacking for result in mutant.results):
        return Advice((Next.POOL,), _not_pooled)
    if mutant.verdict is Verdict.NOT_TESTED:
        return Advice((Next.SITUATION,), _nowhere_steady)
    if mutant.status is Status.MASKED:
        return Advice((stronger,), _masked)
    if mutant.verdict is Verdict.UNDECIDED:
        step = Next.SEEDS if mutant.safety.needed else Next.SITUATION
        return Advice((step,), lambda case: [rates(case), seeds(case)])
    safety = [name for name in known.at_risk if name in scored.pool.requirements(Kind.SAFETY)]
    if mutant.operability.detected:
        return Advice((Next.ORACLE if safety else Next.OPERABILITY,), _operable)
    infected = [result.situation for result in mutant.results if result.infected]
    states = {scored.pool.states.get((key, name)) for key in infected for name in safety}
    if safety and State.STEADY not in states:
        return Advice((Next.SITUATION,), lambda case: [untested(case), only_unsteady(case), margin(case)])
    return Advice((stronger, Next.ORACLE), _not_shown)


def _with_find(case: Case, find: Find, finds: KnownFinds) -> Iterable[str]:
    command = flies(find, case.row.id, finds, case.campaign.name, case.campaign.space.grid)
    return facts(find, case.row.id), f"`{command}` flies it."


def _another_test(case: Case) -> str:
    count = case.score.kill_rate.whole
    reached = f"{counted(count, 'test')} green without a fault" if count else "no test that is green without a fault"
    return f"it reaches {reached}, none shows it: write one that looks at the seam `{case.background.seam}`."


def _not_reached(case: Case) -> Iterable[str]:
    seam, campaign = case.background.seam, case.campaign
    missed = campaign.carrying.get(seam, frozenset()) - case.flown
    if missed:
        first = min(missed, key=campaign.space.rank)
        return (f"the seam `{seam}` carries samples where it was not flown: fly {first}.",)
    return (f"the seam `{seam}` carried no sample in {counted(len(case.flown), 'situation')} flown; {left(case)}",)


def _not_infected(case: Case) -> Iterable[str]:
    reached = {result.situation for result in case.score.results if result.reached}
    where = in_(case.campaign.where(reached.__contains__, case.flown))
    carries = f"the seam `{case.background.seam}` carries samples {where}, none of which the fault changes;"
    return (f"{carries} {left(case)}",)


def _not_pooled(case: Case) -> Iterable[str]:
    flies = f"`scaloft-fi run{in_campaign(flown_in(case.campaign.name))} --mutant {case.row.id}` flies them."
    fewer = f"{len(case.lacking)} of {len(case.infected)} have fewer"
    return (
        f"{violate(sum(bool(flight.revealed) for flight in case.flights))}.",
        f"A verdict takes {LEAST} baselines in each situation where it infects, and {fewer}: {flies}",
    )


def _nowhere_steady(case: Case) -> Iterable[str]:
    states = {name: case.campaign.states(name, case.infected) for name in case.campaign.safety}
    present = set().union(*states.values())
    listed = "; ".join(f"{name} is {states_in_words(counts)}" for name, counts in states.items())
    mend = ", or mend the unmutated drone there" if present & {State.RED, State.UNSTEADY} else ""
    where = f"it infects {in_(case.infected_where)}, and no safety requirement is steady there"
    return (
        f"{where}: {listed or 'the study has none'}.",
        f"Add a situation where it infects and a safety requirement is steady{mend}.",
    )


def _masked(case: Case) -> Iterable[str]:
    masked = f"it changes samples {in_(case.infected_where)}, and the drone flies the same to the bit."
    missing = "A situation is missing where the drone acts on what the fault changes."
    return masked, larger(case) if case.background.stronger else missing, seeds(case)


def _operable(case: Case) -> Iterable[str]:
    tests = [result for result in case.score.results if result.steady_operability]
    killing = sum(bool(result.operability_kills) for result in tests)
    safety = [name for name in case.background.at_risk if name in case.campaign.safety]
    by = " and ".join(case.score.operability.by)
    killed = f"killed in {killing} of {counted(len(tests), 'situation')} where {by} is steady"
    return (
        f"by {by} it is detected, and {killed}; no safety requirement detects it.",
        f"Its cell puts {' and '.join(safety) or 'none'} at risk.",
        SILENT if safety else "Operability has a score of its own.",
        only_unsteady(case),
        margin(case),
    )


def _near(case: Case) -> bool:
    return case.loss is not None and case.loss.share >= NEAR


def _astray(case: Case) -> bool:
    """Whether the drone is far off its path, though it misses no requirement nearly."""
    return not _near(case) and case.off_path_m is not None and case.off_path_m >= ASTRAY_M


def _not_shown(case: Case) -> Iterable[str]:
    """Of a mutant that was put to the test by what its cell puts at risk: margins and paths say what to change."""
    lucky = only_unsteady(case)
    if _astray(case):
        astray = f"it takes the drone {case.off_path_m:.2f} m off its path, and no requirement detects it."
        return astray, SILENT, lucky, margin(case)
    ends = "its ladder ends here" if case.background.laddered else "the fault has no magnitude to raise"
    if _near(case):
        change = larger(case) if case.background.stronger else f"{ends}: a situation with less room may show it."
        return f"near miss: {margin(case)}", lucky, change
    missing = f"{ends}: a situation is missing in which what it changes matters."
    return path(case), lucky, margin(case), larger(case) if case.background.stronger else missing
