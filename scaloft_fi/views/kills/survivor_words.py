"""The facts of a survivor's case, each as a sentence."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from scaloft_fi.analysis.pool import State
from scaloft_fi.analysis.survivor import Case
from scaloft_fi.sim.found import Find
from scaloft_fi.views.score.commands import in_campaign
from scaloft_fi.views.score.verdict import flies_seeds, would_decide

NAMED = 3
"""How many situations a sentence names before it counts the rest."""


def rates(case: Case) -> str:
    """What was seen of an undecided mutant, and why that does not decide."""
    safety, sentences = case.score.safety, []
    for name in case.campaign.safety:
        tests = [result for result in case.score.results if name in result.steady]
        violated = {result.situation: count for result in tests if (count := dict(result.violated).get(name))}
        if violated:
            sentences.append(
                f"{sum(violated.values())} of {sum(result.flown for result in tests)} flights where {name} is steady "
                f"violate it, in {_some(list(violated))}: chance may explain that (p = {safety.p[name]:.2g}, alpha "
                f"{safety.share:g})."
            )
    flown = len(case.tested)
    return " ".join(sentences) or (
        f"no steady requirement is violated in {flown} flight{'s' * (flown != 1)}: too few to decide, whatever they do."
    )


def seeds(case: Case) -> str:
    """How many seeds would decide an undecided mutant, with the command; empty for any other."""
    decides = would_decide(case.score, case.lacking)
    if not decides:
        return ""
    rate = "At that rate" if case.score.seen_in else "If every flight violated,"
    if case.score.safety.needed is None:
        return f"{rate} {decides} would decide: add a situation where it shows more often."
    flies = flies_seeds(case.score, case.campaign.name, case.campaign.space.grid)
    return f"{rate} {decides} would decide: `{flies}`."


def only_unsteady(case: Case) -> str:
    """Where flights violate what the baselines of their seeds hold, if none of it is steady; empty if none do."""
    revealing = [flight for flight in case.flights if flight.revealed]
    where: dict[str, set[str]] = {}
    for flight in revealing:
        for name in flight.revealed:
            where.setdefault(name, set()).add(flight.outcome.situation)
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
        sentences.append(
            f"{name}, which the cell puts at risk, is {states_in_words(counts)} where it infects; "
            f"it is steady {in_(where)}."
        )
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
    return f"{situations(count)} of the grid {'was' if count == 1 else 'were'} not flown."


def larger(case: Case) -> str:
    """What to do where a larger fault may be detected."""
    searches = f"`scaloft-fi margin{in_campaign(case.campaign.name)} {case.row.id}` searches"
    return f"The next rung is {case.background.stronger[0]}; {searches} for the least magnitude that is killed."


def no_more(case: Case) -> str:
    """Why no larger magnitude is asked for."""
    return "its ladder ends here" if case.background.laddered else "the fault has no magnitude to raise"


def states_in_words(states: Mapping[State, int]) -> str:
    """As in: `vacuous in 1 and red in 2 situations`."""
    present = {state: states[state] for state in State if states.get(state)}
    last = next(reversed(present.values()), 0)
    return (
        " and ".join(f"{state.value} in {count}" for state, count in present.items()) + f" situation{'s' * (last != 1)}"
    )


def in_vain(case: Case, finds: Sequence[Find]) -> str:
    """That finds were flown and did not show it; the study has changed since, or other situations drown them."""
    names = listed(find.name for find in finds)
    flown = f"{names} {'was' if len(finds) == 1 else 'were'} flown here with as many seeds"
    return f"{flown}, and it is not detected all the same: `scaloft-fi seek {case.row.id}` seeks another situation."


def situations(count: int) -> str:
    """As in: `1 situation`."""
    return f"{count} situation{'s' * (count != 1)}"


def in_(where: str) -> str:
    """As in: `in human & light`, `everywhere`."""
    return where if where in ("everywhere", "nowhere", "wherever tested") else f"in {where}"


def listed(names: Iterable[str]) -> str:
    """As in: `SR1 and SR2`."""
    return " and ".join(names)


def _some(keys: Sequence[str]) -> str:
    rest = f" and {len(keys) - NAMED} more" if len(keys) > NAMED else ""
    return ", ".join(keys[:NAMED]) + rest
