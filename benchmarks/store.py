"""Measure time and memory of the verbs that read a campaign of 250,000 flights.

    python benchmarks/store.py [--flights N] [--campaign DIR]

The flights are synthetic: every mutant of the catalogue in every situation, with the necessary number of seeds, with
the keys of the study, and with durations and variety of real flights.  A share SAME of them equals their baseline, like
flights that are not infected or masked; the others have numbers and digests of their own.

cpu_s: processor time of the whole command, which is comparable on a busy machine.  wall_s: wall time.  peak_rss_mib:
peak resident memory.  store_mib: size of the file.  put_s: time to write it.
"""

from __future__ import annotations

import checkout  # first: it sets the path and the threads

# isort: split

import hashlib
import itertools
import os
import random
import subprocess
import sys
import tempfile
import time
import zlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.store.archive import STORE_NAME
from scaloft_fi.campaign.store.held import Keys
from scaloft_fi.campaign.store.platforms import fingerprint
from scaloft_fi.campaign.store.store import Store
from scaloft_fi.judge.outcome import TRACK_COLUMNS, Outcome, Violation
from scaloft_fi.judge.requirement import Reading
from scaloft_fi.mutants.mutant import PLACEBO, Mutant
from scaloft_fi.study import Study

SAME = 0.26
"""Share of a mutant's flights that equal their baseline, from the first campaign of 4,064 flights."""
OWN = (0.5, 0.2, 0.25, 0.05)
"""Probability that a flight has its own robustness of a requirement, in the study's order, from the same campaign."""
FREE = 0.5
"""Probability that an axis does not bound the box of the grid in which a subject violates a requirement."""
SLIPS = 0.02
"""Probability that a flight deviates from that box."""
VERBS = {
    "score": ("score",),
    "score_json": ("score", "--format", "json"),
    "kills": ("kills",),
    "worksheet": ("worksheet",),
    "status": ("status",),
    "export": ("export", "--format", "csv", "--output", os.devnull),
    "report": ("report", "--output", "{folder}/report.html"),
}


class Maker:
    """Makes synthetic outcomes.

    Args:
        study: study of the flights.
        draw: random numbers of the outcomes.
    """

    def __init__(self, study: Study, draw: random.Random) -> None:
        self._study, self._draw, self._axes = study, draw, study.grid.axes
        self._noise = np.random.default_rng(0)
        self._boxes: dict[tuple[str, str], list[int | None]] = {}

    def baseline(self, flight: Flight) -> Outcome:
        """An outcome of the baseline."""
        realised = tuple((axis.id, self._draw.random() < 0.9) for axis in self._study.grid.axes)
        return replace(self._own(flight), realised=realised)

    def beside(self, flight: Flight, baseline: Outcome) -> Outcome:
        """An outcome of a mutant beside its baseline."""
        carried = self._draw.randrange(100, 5000)
        if flight.mutant == PLACEBO:
            return replace(baseline, subject=flight.subject, realised=(), carried=carried)
        if self._draw.random() < SAME:
            altered, at_s = self._draw.choice([(0, None), (self._draw.randrange(1, 100), self._time_s())])
            return replace(
                baseline, subject=flight.subject, realised=(), carried=carried, altered=altered, infected_at_s=at_s
            )
        altered = self._draw.randrange(1, carried)
        return replace(self._own(flight), carried=carried, altered=altered, infected_at_s=self._time_s())

    def _own(self, flight: Flight) -> Outcome:
        readings, violations = [], []
        for requirement, own in zip(self._study.requirements, OWN, strict=True):
            breaks = self._breaks(flight, requirement.name) != (self._draw.random() < SLIPS)
            at_s = self._time_s() if breaks else None
            rho = self._draw.random() if self._draw.random() < own else 1.0
            rho = -rho if at_s is not None else rho
            triggered = self._draw.randrange(3)
            readings.append(Reading(requirement.name, requirement.kind, rho, at_s, triggered, open=False))
            if at_s is not None:
                x, y, z = (self._draw.uniform(-4, 8) for _ in range(3))
                struck = self._draw.choice(["", "wall", "bar"])
                violations.append(Violation(requirement.name, requirement.kind, at_s, x, y, z, struck))
        digest = hashlib.sha256(self._draw.randbytes(16)).hexdigest()
        duration_s = self._time_s()
        return Outcome(
            flight.subject,
            flight.situation.key,
            flight.seed,
            ending="landed",
            readings=tuple(readings),
            violations=tuple(violations),
            duration_s=duration_s,
            digest=digest,
            perceived_digest=digest[::-1],
            track=self._track(duration_s),
        )

    def _track(self, duration_s: float) -> bytes:
        """A walk at random as a packed trajectory, at the centimetre so that it packs like a real one."""
        values = self._noise.normal(0.0, 0.1, (int(duration_s * 5) + 1, len(TRACK_COLUMNS))).cumsum(axis=0).round(2)
        values[:, 0] = np.arange(len(values)) / 5
        return zlib.compress(values.astype("<f4").tobytes(), 1)

    def _breaks(self, flight: Flight, requirement: str) -> bool:
        """Whether the situation is in the box in which the subject violates the requirement."""
        box = self._boxes.setdefault((flight.subject.id, requirement), [])
        if not box:
            box += [None if self._draw.random() < FREE else self._draw.choice(axis.values).id for axis in self._axes]
        levels = dict(flight.situation.levels)
        return all(value in (None, levels[axis.id]) for axis, value in zip(self._axes, box, strict=True))

    def _time_s(self) -> float:
        return round(self._draw.uniform(0.0, 75.0) * 20) / 20


def flights(study: Study) -> Iterator[Flight]:
    """Yield flights without end by situation and seed; the baseline is first."""
    subjects: tuple[Mutant | None, ...] = (None, PLACEBO, *study.catalogue)
    for seed in itertools.count():
        for situation in study.grid.situations:
            yield from (Flight(subject, situation, seed) for subject in subjects)


def fill(study: Study, path: Path, number: int) -> None:
    """Write a store of `number` flights."""
    keys, maker = Keys(study), Maker(study, random.Random(0))
    listed = list(itertools.islice(flights(study), number))

    def rows() -> Iterator[tuple[str, Outcome]]:
        baseline = maker.baseline(listed[0])
        for flight in listed:
            if flight.mutant is None:
                baseline = maker.baseline(flight)
            yield keys.key(flight), maker.beside(flight, baseline) if flight.mutant else baseline

    with Store(path) as store:
        store.set_meta(fingerprint())
        store.plan(map(keys.planned, listed))
        store.put_all(rows())


def measure(folder: Path, words: tuple[str, ...]) -> dict[str, float]:
    """Measure a whole command, including the start of the interpreter."""
    words = tuple(word.format(folder=folder) for word in words)
    call = [sys.executable, "-m", "scaloft_fi", *words, "--campaign", str(folder), "--study", str(checkout.ROOT)]
    begin_s = time.perf_counter()
    with subprocess.Popen(call, cwd=checkout.ROOT, stdout=subprocess.DEVNULL) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{' '.join(call)}: exit code {process.returncode}")
    return {
        "cpu_s": round(used.ru_utime + used.ru_stime, 2),
        "wall_s": round(time.perf_counter() - begin_s, 2),
        "peak_rss_mib": round(used.ru_maxrss / (1024**2 if sys.platform == "darwin" else 1024), 1),
    }


def main() -> None:
    """Measure and print."""
    parser = checkout.parser(__doc__)
    parser.add_argument("--flights", type=int, default=250_000, help="how many (default: 250,000)")
    parser.add_argument("--campaign", type=Path, help="folder to make it in, and to keep it (with a / in it)")
    options = parser.parse_args()
    figures: dict[str, Any] = {"flights": options.flights}
    with tempfile.TemporaryDirectory(prefix="store") as made:
        folder = options.campaign or Path(made)
        path = folder / STORE_NAME
        if not path.exists():
            begin_s = time.perf_counter()
            fill(Study.open(checkout.ROOT), path, options.flights)
            figures["put_s"] = round(time.perf_counter() - begin_s, 1)
        figures["store_mib"] = round(path.stat().st_size / 1024**2, 1)
        figures |= {name: measure(folder, words) for name, words in VERBS.items()}
    checkout.tell(figures)


if __name__ == "__main__":
    main()
