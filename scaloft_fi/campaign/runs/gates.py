"""Gates: checks that must pass before a score is valid.  A failed gate is named, and no score is printed."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence

from scaloft_fi.analysis.detection import Sample, Spending, detect
from scaloft_fi.analysis.pool import Pool, State
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.campaign.runs.options import MOST_INVALID
from scaloft_fi.errors import GateError
from scaloft_fi.hazop.name import cell_of
from scaloft_fi.judge.outcome import BASELINE, PLACEBO, TRACK_COLUMNS, Outcome, unpack_track
from scaloft_fi.judge.requirement import Compliance, Kind
from scaloft_fi.judge.status import JudgedFlight, Status, baselines_of, digests, flights_of
from scaloft_fi.sim.log import Ending

NAMED = 3
"""Greatest number of flights that a message names; the message counts the others."""
RISE_M = 0.3
"""A drone that never rises by more than this did not leave the ground [m]."""
ONCE = Spending()
"""All of the usual alpha at once."""
_Z = TRACK_COLUMNS.index("z_m")


def check(
    outcomes: Iterable[Outcome],
    roster: Roster,
    *,
    canary: str | None,
    whole_grid: bool,
    part: bool = False,
    repeats: Sequence[Outcome] = (),
    max_invalid: float = MOST_INVALID,
    deterministic: bool = True,
    spending: Spending = ONCE,
) -> None:
    """Check the gates on the flights of a run.

    Args:
        outcomes: outcomes of the run, with baselines; an outcome needs its track where `asks_for_track` holds, to tell
            whether the drone left the ground.
        roster: names the controls.
        canary: id of the control whose flight proves that faults reach the drone; None in a study without controls.
        whole_grid: whether every situation was flown, so that every control must show an effect.
        part: whether this is one part of a run; then a missing effect is no failure, because another part may have it.
        repeats: outcomes of repeated flights.
        max_invalid: greatest share 0..1 of invalid flights.
        deterministic: whether flights repeat their bits; if not, PLACEBO must not be detected by the score's own test,
            instead of being the baseline bit for bit, and a repeated flight proves nothing.
        spending: of alpha by that test.

    Raises:
        GateError: a gate failed; the message names each failed gate.
    """
    listed = list(outcomes)
    failed = [
        *_too_many_invalid(listed, max_invalid),
        *(_same_bits(listed, repeats) if deterministic else _placebo_detected(listed, spending)),
        *_raising(listed),
        *_grounded(listed),
    ]
    if not part:
        failed += [
            *_nothing_steady(listed),
            *_silent_controls(flights_of(listed), roster, canary, whole_grid),
        ]
    if failed:
        raise GateError("gate failed: " + "; ".join(failed))


def _too_many_invalid(outcomes: Sequence[Outcome], most: float) -> Iterator[str]:
    broken = [outcome for outcome in outcomes if outcome.invalid]
    if len(broken) > most * len(outcomes):
        names = _listed([f"{outcome.name} ({outcome.invalid})" for outcome in broken])
        yield f"{len(broken)} of {len(outcomes)} flights are invalid, more than {most:.0%}: {names}"


def _same_bits(outcomes: Sequence[Outcome], repeats: Sequence[Outcome]) -> Iterator[str]:
    yield from _differ("PLACEBO differs from the baseline", _placebos(outcomes))
    yield from _differ("a repeated flight differs from the first", _repeated(outcomes, repeats))


def _placebo_detected(outcomes: Sequence[Outcome], spending: Spending) -> Iterator[str]:
    """Fails if the score's test takes PLACEBO, judged as if it altered samples, for a fault."""
    flown: dict[str, list[tuple[str, ...]]] = {}
    for outcome in outcomes:
        if outcome.mutant == PLACEBO and not outcome.invalid:
            names = tuple(violation.requirement for violation in outcome.violations)
            flown.setdefault(outcome.situation, []).append(names)
    samples = [Sample(situation, tuple(names), infected=True) for situation, names in flown.items()]
    detection = detect(PLACEBO, samples, Pool.of(outcomes), spending, Kind.SAFETY)
    if detection.detected:
        p = ", ".join(f"{name} p = {detection.p[name]:.2g}" for name in detection.by)
        yield f"PLACEBO, which does nothing, is detected by the score's test ({p}): the flights are no fair comparison"


def _differ(what: str, pairs: Iterable[tuple[Outcome, Outcome]]) -> Iterator[str]:
    names = [first.name for first, second in pairs if digests(first) != digests(second)]
    if names:
        yield f"{what}: {_listed(names)}"


def _placebos(outcomes: Sequence[Outcome]) -> Iterator[tuple[Outcome, Outcome]]:
    baselines = baselines_of(outcomes)
    for outcome in outcomes:
        baseline = baselines.get((outcome.situation, outcome.seed))
        if outcome.mutant == PLACEBO and baseline and not (outcome.invalid or baseline.invalid):
            yield outcome, baseline


def _repeated(outcomes: Sequence[Outcome], repeats: Sequence[Outcome]) -> Iterator[tuple[Outcome, Outcome]]:
    first = {outcome.name: outcome for outcome in outcomes}
    for repeat in repeats:
        known = first.get(repeat.name)
        if known and not (known.invalid or repeat.invalid):
            yield known, repeat


def _nothing_steady(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Fails if no pair is steady; without a pool, if no baseline holds a safety requirement that it triggers."""
    baselines = [outcome for outcome in outcomes if outcome.mutant == BASELINE]
    states = [pair.state for pair in Pool.of(baselines).pairs.values() if pair.kind is Kind.SAFETY]
    if State.STEADY in states:
        return
    names = _listed(sorted({outcome.situation for outcome in baselines}))
    if any(state is not State.UNKNOWN for state in states):
        yield f"no situation flown has a steady pair, where the unmutated drone holds a safety requirement: {names}"
    elif not any(r.kind is Kind.SAFETY and r.compliance is Compliance.HELD for o in baselines for r in o.readings):
        yield f"no situation flown has a baseline that holds a safety requirement: {names}"


def _raising(outcomes: Sequence[Outcome]) -> Iterator[str]:
    names = [f"{o.name} ({o.stack_error})" for o in outcomes if o.mutant == BASELINE and o.stack_error]
    if names:
        yield f"the stack raises without any fault: {_listed(names)}"


def asks_for_track(outcome: Outcome) -> bool:
    """Whether the track is needed to tell that the drone left the ground: for a baseline that did not land.

    A flight ends as landed only after take-off, so a landed flight needs no track.
    """
    return outcome.mutant == BASELINE and not outcome.invalid and outcome.ending != Ending.LANDED


def _grounded(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """Fails if a baseline never leaves the ground: a standing drone would hold every safety requirement.

    The check uses the trajectory, because no requirement of the study need cover take-off.
    """
    names = [o.name for o in outcomes if asks_for_track(o) and o.track and _rise_m(o.track) < RISE_M]
    if names:
        yield f"the drone never leaves the ground without any fault: {_listed(names)}"


def _rise_m(track: bytes) -> float:
    """Greatest height of a trajectory above its start [m]."""
    heights = [row[_Z] for row in unpack_track(track)]
    return max(heights) - heights[0]


def _silent_controls(
    flights: Iterable[JudgedFlight], roster: Roster, canary: str | None, whole_grid: bool
) -> Iterator[str]:
    by_control: dict[str, list[JudgedFlight]] = {}
    for flight in flights:
        if cell_of(flight.outcome.mutant) in roster.controls and flight.status is not Status.INVALID:
            by_control.setdefault(flight.outcome.mutant, []).append(flight)
    judged: Collection[str] = by_control if whole_grid else by_control.keys() & {canary}
    names = [name for name in by_control if name in judged and not any(map(_shows, by_control[name]))]
    if names:
        yield f"a control shows nothing, so faults may not reach the drone: {_listed(names)}"


def _shows(flight: JudgedFlight) -> bool:
    return bool(flight.revealed or flight.operability_revealed)


def _listed(names: Sequence[str]) -> str:
    rest = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return ", ".join(names[:NAMED]) + rest
