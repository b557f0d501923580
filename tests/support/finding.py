"""A drone without physics whose mutants fail by rule, for the tests of the search; finds by hand."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from paper_flyer import Whole
from running import quiet
from studies import GRIDS, copied

from scaloft_fi.analysis.seeking import Breach, Signature
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.runs.gates import RunOptions
from scaloft_fi.campaign.seeking.finds import Allowance, SeekReport
from scaloft_fi.campaign.seeking.seek import seek
from scaloft_fi.judge.outcome import Outcome, Violation
from scaloft_fi.judge.requirement import Kind, Reading
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.sim.grid import Break, Evidence, Find
from scaloft_fi.sim.situation import Situation
from scaloft_fi.streams import key_words
from scaloft_fi.study import KnownFinds, Study

Rule = Callable[[Situation], float]
"""Robustness of SR2 in a situation, without noise."""


def number(situation: Situation, axis: str, benign: float) -> float:
    """The number of a free axis."""
    return dict(situation.numbers).get(axis, benign)


def fast(situation: Situation) -> float:
    """Violated where a person is and the drone cruises at 0.8 m/s or more; wind does not matter."""
    return 0.8 - number(situation, "Cs", 0.5) + (0.0 if situation["H"] == 1 else 0.5)


def never(situation: Situation) -> float:
    """Never violated."""
    return 0.4


def everywhere(situation: Situation) -> float:
    """Violated in the benign situation too."""
    return -0.2


def landed(
    study: Study,
    flight: Flight,
    readings: Sequence[Reading],
    violations: Sequence[Violation],
    digest: str,
    *,
    mutated: bool,
) -> Outcome:
    """A flight that lands after 40 s; a mutant alters samples from the first second on."""
    return Outcome(
        flight.subject,
        flight.situation.key,
        flight.seed,
        ending="landed",
        readings=tuple(readings),
        violations=tuple(violations),
        carried=10 * mutated,
        altered=3 * mutated,
        infected_at_s=1.0 if mutated else None,
        duration_s=40.0,
        digest=digest,
        perceived_digest="p",
        realised=() if mutated else tuple((axis.id, True) for axis in study.grid.axes),
    )


def sought(study: Study, mutants: Sequence[Mutant], folder: Path, *, jobs: int = 1, **more: Any) -> SeekReport:
    """A search with seed 0 that nobody watches and whose finds nobody saves, where nothing else is said."""
    told = {"seed": 0, "allowance": Allowance(), "progress": quiet(), "save": lambda _finds: None, **more}
    return seek(study, mutants, folder, RunOptions(jobs=jobs), **told)


@dataclass
class Ruled(Whole):
    """A flyer that notes on disk what it flew.

    rules: robustness of SR2 by mutant; baseline: that of the drone; first: of SR1, operable: of OP1, in all flights.
    """

    path: Path
    rules: Mapping[str, Rule] = field(default_factory=dict)
    baseline: Rule = lambda _situation: 0.4
    first: Rule = lambda _situation: 0.3
    operable: Rule = lambda _situation: 0.5
    noise: float = 0.01

    def __call__(self, study: Study, flight: Flight) -> Outcome:
        with self.path.open("a") as file:
            file.write(f"{flight.name}\n")
        mutated = flight.mutant is not None and flight.mutant != PLACEBO
        other = everywhere if flight.subject.guideword == "REVERSE" else never  # controls show themselves
        rule = self.rules.get(flight.subject.id, other) if mutated else self.baseline
        chance = key_words("noise", flight.situation.key, flight.seed, "mutant" if mutated else "")[0] / 2**64
        rho = rule(flight.situation) + self.noise * (2 * chance - 1)
        able = self.operable(flight.situation)
        readings = (
            Reading("SR1", Kind.SAFETY, self.first(flight.situation), None, 1, open=False),
            Reading("SR2", Kind.SAFETY, rho, 7.0 if rho < 0 else None, 1, open=False),
            Reading("OP1", Kind.OPERABILITY, able, None if able > 0 else 30.0, 1, open=False),
        )
        violations = (Violation("SR2", Kind.SAFETY, 7.0, 0.0, 1.0, 1.6, "person"),) if rho < 0 else ()
        digest = f"{flight.subject.id if mutated else ''}{flight.situation.key}{flight.seed}"
        return landed(study, flight, readings, violations, digest, mutated=mutated)

    @property
    def flown(self) -> list[str]:
        return self.path.read_text().splitlines() if self.path.exists() else []


def found(mutant: str, situation: str = "T0O0W0D0H2Cs=0.8", *, others: tuple[str, ...] = (), struck: str = "") -> Find:
    """A find as `seek` writes it: six of six flights violate SR2."""
    evidence = Evidence("SR2", 1, 0.00025, 0.005, 6, 6, struck, 10, 10, 0.071, 0.02, 10)
    shows = dict.fromkeys((mutant, *others), evidence)
    return Find(f"shows-{mutant}", situation, ("human walks", "cruise speed 0.8 m/s"), mutant, shows, 0)


PLACE = (0.0, 1.0, 1.6)
"""Where violations of this drone are [m]."""


def breached(violations: Sequence[Violation], belief: str = "", leg: str = "home to corner") -> tuple[Breach, ...]:
    """The ways in which these violations near the corner break the drone, all with this wrong belief."""
    wrong = (1.5, "m") if belief else (0.0, "")
    ways = [Signature(one.requirement, one.struck, leg, "corner", belief) for one in violations]
    return tuple(
        Breach(way, (way.requirement,), one.t_s, PLACE, *wrong) for way, one in zip(ways, violations, strict=True)
    )


BAR = Break(
    name="breaks-SR1-bar-corner_to_end-obstacle_map",
    situation="T1O0W0D1H0Cs=0.8",
    words=("corner", "dark", "cruise speed 0.8 m/s"),
    requirement="SR1",
    struck="bar",
    leg="corner to end",
    near="bar",
    belief="obstacle map",
    error=0.58,
    unit="m",
    violated=10,
    flights=10,
    alike=9,
    flight=0,
    t_s=25.45,
    place=(-1.614, 7.714, 1.605),
    seed=0,
)
"""A break as `seek baseline` writes it."""


def known(*finds: Find) -> KnownFinds:
    """Finds that fit their study."""
    return KnownFinds(finds, grid="paper+found")


def flies(mutant: str, find: str = "", campaign: str = "") -> str:
    """The command that flies a find of `found`."""
    where = f" --campaign {campaign}" if campaign else ""
    return (
        f"scaloft-fi run --grid paper+found{where} --mutant {mutant} --situation {find or f'shows-{mutant}'} --seeds 6"
    )


def small_study(folder: Path) -> Study:
    """A copy of the reference study with a grid that is searched fast."""
    copied(folder, "found.yaml")
    shutil.copy(GRIDS / "small.yaml", folder / "sim" / "grids")
    return Study.open(folder, "small")
