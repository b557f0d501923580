"""The results on the page of the bugs, in Markdown."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

from experiments.bugs.bug import Bug
from experiments.bugs.coupling import Coupling, detecting_share, mean_excess, relabelled_p, share
from experiments.bugs.evidence import Published, Samples, coupling, samples, verdict, violated_by
from experiments.bugs_plan import LEVEL, REFERENCE, SITUATIONS, TOGETHER
from experiments.kept_flights import Flights
from scaloft_fi.judge.outcome import Outcome


def flown(bugs: Sequence[Bug], flights: Flights, seen: Published) -> str:
    """The section with the results of the bugs.

    Args:
        bugs: the bugs.
        flights: by key of the bug, or `REFERENCE`, and name of the flight.
        seen: the published campaign.
    """
    own = {bug.key: samples(flights[bug.key].values(), flights[REFERENCE]) for bug in bugs}
    same = {bug.key: [other.key for other in bugs if _alike(flights[bug.key], flights[other.key])] for bug in bugs}
    counted = [bug for bug in bugs if seen.killing(bug.cell)]
    apart = [bug for bug in bugs if not seen.killing(bug.cell)]
    found = {
        bug.key: coupling(bug, own[bug.key], seen, sum(other.key in same[bug.key] for other in group))
        for group in (counted, apart)
        for bug in group
    }
    lines = ["", "## Flown", "", *_answer([found[bug.key] for bug in counted], seen), ""]
    lines += [_reference(flights[REFERENCE], seen), ""]
    lines += [*_twins(same), *_couplings(counted, found, own, seen), "", *_sets(counted, own, seen), ""]
    lines += [*_others(counted, found, seen), "", *_apart(apart, found, own, seen), "", *_violations(bugs, flights)]
    return "\n".join(lines) + "\n"


def _alike(one: Mapping[str, Outcome], other: Mapping[str, Outcome]) -> bool:
    return {name: o.digest for name, o in one.items()} == {name: o.digest for name, o in other.items()}


def _answer(counted: Sequence[Coupling], seen: Published) -> Iterator[str]:
    populations = {"that put a fault to the test": seen.tested, "of the grid": frozenset(seen.pool.flown)}
    for number, (words, population) in enumerate(populations.items()):
        excess, p = mean_excess(counted, population), relabelled_p(counted, population)
        told = f"{excess:+.3f} (p = {p:.2g}, {len(counted)} bugs, {len(population)} situations {words})"
        if number == 0:
            shown = "Yes: killing" if excess > 0 and p <= LEVEL else "These bugs do not show that killing"
            yield f"**{shown} situations detect the bug of their cell oftener than random ones.**  Mean excess {told}."
        else:
            yield f"The easier comparison: mean excess {told}."
    yield from _without_the_greatest(counted, seen.tested)


def _without_the_greatest(counted: Sequence[Coupling], tested: frozenset[str]) -> Iterator[str]:
    """How much of the answer one bug carries; this was not registered."""
    rest = sorted(counted, key=lambda one: one.excess(tested))[:-1]
    if rest:
        told = f"{mean_excess(rest, tested):+.3f} (p = {relabelled_p(rest, tested):.2g}, {len(rest)} bugs)"
        yield f"Not registered: without the bug of the greatest excess the mean is {told}."


def _reference(flights: Mapping[str, Outcome], seen: Published) -> str:
    other = sum(violated_by(one) != seen.violated[name] for name, one in flights.items())
    return (
        f"{other} of {len(flights)} flights of the reference stack violate other requirements than the published ones."
    )


def _twins(same: Mapping[str, Sequence[str]]) -> Iterator[str]:
    groups = sorted({tuple(keys) for keys in same.values() if len(keys) > 1})
    if groups:
        told = "; ".join(" and ".join(keys) for keys in groups)
        yield f"Bit-identical flights: {told}."
        yield ""


def _couplings(
    counted: Sequence[Bug], found: Mapping[str, Coupling], own: Mapping[str, Samples], seen: Published
) -> Iterator[str]:
    tested = seen.tested
    yield "| bug | cell | verdict on the bug | killing situations | detect it alone | of all that test | excess | p | \
coupled |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for bug in counted:
        one = found[bug.key]
        hits, every = len(one.alone & one.killing), len(one.alone & tested)
        told = verdict(bug.key, own[bug.key], seen, own[bug.key]).verdict.words
        yield (
            f"| {bug.key} | {bug.cell} | {told} | {len(one.killing)} | {hits} | {every} of {len(tested)} "
            f"| {one.excess(tested):+.3f} | {one.p(tested):.2g} | {_coupled(one, tested)} |"
        )


def _coupled(one: Coupling, tested: frozenset[str]) -> str:
    if not one.alone:
        return "no situation detects it"
    if tested <= one.alone:
        return "every situation detects it"
    return "yes" if one.excess(tested) > 0 and one.p(tested) <= LEVEL else "no"


def _sets(counted: Sequence[Bug], own: Mapping[str, Samples], seen: Published) -> Iterator[str]:
    yield "Share of sets of situations that detect the bug:"
    yield ""
    yield f"| bug | {TOGETHER} killing | {TOGETHER} random | all killing | as many random |"
    yield "|---|---|---|---|---|"
    for bug in counted:
        killing, flights, key = seen.killing(bug.cell), own[bug.key], bug.key

        def detects(chosen: Collection[str], key: str = key, flights: Samples = flights) -> bool:
            return verdict(key, flights, seen, chosen).detected

        few = min(TOGETHER, len(killing))
        shares = (
            detecting_share(detects, killing, few, key, "killing"),
            detecting_share(detects, seen.tested, few, key, "random"),
            float(detects(killing)),
            detecting_share(detects, seen.tested, len(killing), key, "as many"),
        )
        yield f"| {key} | {' | '.join(f'{value:.2f}' for value in shares)} |"


def _others(counted: Sequence[Bug], found: Mapping[str, Coupling], seen: Published) -> Iterator[str]:
    yield "Share of killing situations that detect the bug alone: of its own cell, and mean over the cells of other"
    yield "parameters whose default mutant has kills:"
    yield ""
    yield "| bug | own cell | other cells |"
    yield "|---|---|---|"
    for bug in counted:
        parameter, alone = bug.cell.split("-")[1], found[bug.key].alone
        sets = [seen.killing(cell) for cell in seen.mutants if cell.split("-")[1] != parameter]
        others = [share(alone, killing) for killing in sets if killing]
        mean = f"{sum(others) / len(others):.2f} ({len(others)})" if others else "none"
        yield f"| {bug.key} | {share(alone, found[bug.key].killing):.2f} | {mean} |"


def _apart(
    apart: Sequence[Bug], found: Mapping[str, Coupling], own: Mapping[str, Samples], seen: Published
) -> Iterator[str]:
    yield "Apart, because the mutant of the cell is killed nowhere:"
    yield ""
    yield "| bug | cell | verdict on the mutant | verdict on the bug | situations where it differs | detect it alone |"
    yield "|---|---|---|---|---|---|"
    for bug in apart:
        flights = own[bug.key]
        told = verdict(bug.key, flights, seen, flights).verdict.words
        differs = f"{sum(sample.infected for sample in flights.values())} of {len(flights)}"
        mutant, alone = seen.mutants[bug.cell].verdict.words, len(found[bug.key].alone)
        yield f"| {bug.key} | {bug.cell} | {mutant} | {told} | {differs} | {alone} |"


def _violations(bugs: Sequence[Bug], flights: Flights) -> Iterator[str]:
    yield f"Flights of each bug that violate, over {SITUATIONS} situations:"
    yield ""
    yield "| bug | flights | SR1 | SR2 | OP1 | stack raised an error |"
    yield "|---|---|---|---|---|---|"
    for bug in bugs:
        own = flights[bug.key].values()
        named = [{violation.requirement for violation in one.violations} for one in own]
        counts = [sum(name in names for names in named) for name in ("SR1", "SR2", "OP1")]
        raised = sum(bool(one.stack_error) for one in own)
        yield f"| {bug.key} | {len(own)} | {' | '.join(map(str, counts))} | {raised} |"
