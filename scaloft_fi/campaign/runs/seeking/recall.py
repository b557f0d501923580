"""Fly baselines again, bit for bit, to see what their stages believed before they violated a requirement.

Outcomes do not keep what a stack believed; so a flight whose signature is asked for is flown once more and listened to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from scaloft_fi.analysis.seeking import Breach, breaches
from scaloft_fi.campaign.plan.flight import Flight
from scaloft_fi.campaign.processes.pool import Pool
from scaloft_fi.campaign.runs.campaign import Campaign
from scaloft_fi.errors import ScaloftError
from scaloft_fi.judge.outcome import Violation
from scaloft_fi.stack.declaration import PlainWire

if TYPE_CHECKING:
    from scaloft_fi.study import Study

S = TypeVar("S")

Told = tuple[Breach, ...]
Recall = Callable[["Study", Flight, Sequence[Violation]], Told]
"""Flies a baseline again, and tells what its violations of safety requirements say."""
_Task = tuple[Flight, Sequence[Violation]]


class ListeningWire(PlainWire):
    """Delivers every sample unchanged, and keeps those of some seams.

    Attributes:
        kept: time [s] and sample of each delivery, by seam.
    """

    def __init__(self, seams: Iterable[str]) -> None:
        self.kept: dict[str, list[tuple[float, Any]]] = {seam: [] for seam in seams}

    def listens(self, seam: str) -> bool:
        """Whether the samples of `seam` are kept."""
        return seam in self.kept

    def cross(self, seam: str, t_s: float, sample: S | None) -> S | None:
        """Return `sample`."""
        if sample is not None and seam in self.kept:
            self.kept[seam].append((t_s, sample))
        return sample


def recalled(study: Study, flight: Flight, violations: Sequence[Violation]) -> Told:
    """What the violations of a baseline say, the earliest first; it is flown up to the last of them.

    Raises:
        ScaloftError: the flight cannot be flown, or a claim of the stack fails.
    """
    from scaloft_fi.sim.flight import FlightLoop, physics_server
    from scaloft_fi.sim.load import claims_of
    from scaloft_fi.stack.declaration import TICK_HZ

    claims = claims_of(study.stack, study.signals)
    wire = ListeningWire(claim.seam for claim in claims if claim.seam)
    scenario = study.scenario(flight.situation)
    ticks = round(TICK_HZ * max(violation.t_s for violation in violations))
    with physics_server() as client:
        loop = FlightLoop(client, study.sim, scenario, flight.seed, wire)
        while loop.ticks <= ticks and loop.tick():
            loop.advance()
        return breaches(loop.log(), violations, study.requirements, scenario.world, claims, wire.kept)


class Recalls:
    """What was recalled in a search.

    Args:
        campaign: the open campaign.
        recall: flies a flight again.

    Attributes:
        count: number of flights that were flown again.
    """

    def __init__(self, campaign: Campaign, recall: Recall) -> None:
        self._campaign, self._work = campaign, _Recalling(campaign.study, recall)
        self._told: dict[str, Told] = {}
        self.count = 0

    def unknown(self, flights: Sequence[Flight]) -> tuple[Flight, ...]:
        """Those of the flights that were not recalled yet."""
        return tuple(flight for flight in flights if flight.name not in self._told)

    def look(self, violations: Mapping[Flight, Sequence[Violation]]) -> None:
        """Fly those of the flights again that were not recalled yet, side by side; fewer once the user stops.

        The processes end here: if they lived on, they would hold on to the ends of others, and others to theirs.

        Args:
            violations: of safety requirements by flight, at least one each.
        """
        new = [(flight, violations[flight]) for flight in self.unknown(tuple(violations))]
        if not new:
            return
        self._campaign.prepare()
        jobs, stop = min(self._campaign.options.jobs, len(new)), self._campaign.stopped
        with Pool(self._work, jobs, left=lambda task, _: task, lost=_lost, stop=stop, patient=False) as pool:
            self._told |= dict(pool.map(new))
        self.count += len(new)

    def of(self, flight: Flight) -> Told:
        """How a recalled flight violates the safety requirements; nothing where the harness failed."""
        return self._told.get(flight.name, ())


class _Recalling:
    """The work of a process: raises what is the user's to mend, never for a failure of the harness."""

    def __init__(self, study: Study, recall: Recall) -> None:
        self._study, self._recall = study, recall

    def __call__(self, task: _Task, report: Callable[[tuple[str, Told]], None]) -> None:
        flight, violations = task
        try:
            told = self._recall(self._study, flight, violations)
        except ScaloftError:
            raise
        except Exception:  # noqa: BLE001 - as for a flight that is invalid: it says nothing
            told = ()
        report((flight.name, told))


def _lost(task: _Task, _: str) -> Iterable[tuple[str, Told]]:
    return ((task[0].name, ()),)
