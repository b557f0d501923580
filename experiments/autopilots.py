"""Fly real autopilots below the companion: accept each on clean baselines, and fly the same flights again.

    python -m experiments.autopilots --program KIND=PATH... [--jobs N]     # what is missing of the baselines
    python -m experiments.autopilots --program KIND=PATH... --again        # flies them again, and compares digests

Flights are kept beside the page, in `autopilots_accepted.jsonl.gz`.  The programs are the user's: the page says which
were flown.
"""

from __future__ import annotations

import hashlib
import re
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

from experiments import PUBLISHED
from experiments.flights import Flights, complete, flights_of, holds, names_of, read, shared
from experiments.operating_point import LIGHT
from experiments.pages import Row, blocks, parser, registered, table
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.study import Study
from scaloft_fi.verbs.new import firmware_files, write_new

NAME = "autopilots"
ACCEPTED = f"{NAME}_accepted.jsonl.gz"
KINDS = ("betaflight", "px4", "ardupilot", "lines")
BEFORE = "px4, barometer and magnetometer"
"""An arm of an adapter that is no more; its flights cannot be flown again."""
FURTHER = {BEFORE: "px4", "px4, barometer of 0.2 m": "px4", "ardupilot, battery": "ardupilot"}
"""Arms whose firmware gets the further sensors that `scaloft-fi new --firmware` gives it; the others do not."""
ARMS = {kind: kind for kind in KINDS} | FURTHER
"""The kind of each arm."""
EMPTY = tuple(key for key in LIGHT if key.endswith("H0"))
"""The light situations without a person."""
SEEDS, FURTHER_SEEDS, LATEST_SEEDS = range(3000, 3010), range(3010, 3020), range(3020, 3030)
LEAST_HELD, LEAST_SITUATIONS = 9, 7
HELD = ("SR1", "OP1")


def study_of(arm: str, program: Path, folder: Path) -> Study:
    """The study that `scaloft-fi new --firmware` writes, with the further sensors or without."""
    write_new(folder, firmware_files(ARMS[arm], program))
    if arm not in FURTHER:
        path = folder / "sim" / "stack.yaml"
        path.write_text(re.sub(r"\n  sensors: \[.*?\]", "\n  sensors: []", path.read_text(encoding="utf-8")))
    return Study.open(folder)


def names(arm: str) -> list[str]:
    """The flights by which the firmware of an arm is accepted."""
    seeds = LATEST_SEEDS if arm.endswith("0.2 m") else FURTHER_SEEDS if arm in FURTHER else SEEDS
    return names_of([BASELINE], EMPTY, seeds)


def accepted(outcomes: Mapping[str, Outcome]) -> bool:
    """Whether nine of ten baselines hold in seven of the eight situations."""
    held = (sum(holds(one, HELD) for one in outcomes.values() if one.situation == key) for key in EMPTY)
    return sum(count >= LEAST_HELD for count in held) >= LEAST_SITUATIONS


def told(flights: Flights) -> str:
    """The section with the results."""
    return blocks(
        "## Flown",
        f"{sum(map(len, flights.values()))} of {sum(len(names(arm)) for arm in ARMS)} flights.",
        table(("firmware", *EMPTY, "accepted", "shortest", "longest"), _rows(flights)),
        "Flights that hold SR1 and OP1, of ten; duration of the shortest and the longest flight [s].",
        *_failures(flights),
    )


def _rows(flights: Flights) -> Iterator[Row]:
    for kind in ARMS:
        flown = flights[kind]
        held = [sum(holds(one, HELD) for one in flown.values() if one.situation == key) for key in EMPTY]
        durations = [one.duration_s for one in flown.values()]
        verdict = "yes" if accepted(flown) else "no"
        yield (kind, *held, verdict, f"{min(durations):.1f}", f"{max(durations):.1f}")


def _failures(flights: Flights) -> Iterator[str]:
    lines = [
        f"- {kind}, {one.situation}, seed {one.seed}: "
        + ("; ".join(f"{v.requirement} at {v.t_s:.1f} s, {v.struck or '-'}" for v in one.violations) or one.ending)
        for kind in ARMS
        for one in flights.get(kind, {}).values()
        if not holds(one, HELD)
    ]
    if lines:
        yield "\n".join(["What does not hold:", "", *lines])


def main() -> None:
    """Fly what is missing and write the page, or fly again and compare."""
    options = parser(__doc__, NAME)
    options.add_argument("--program", action="append", default=[], help="KIND=PATH (repeatable)")
    options.add_argument("--again", action="store_true", help="fly the stored flights again, and compare digests")
    asked, kept = options.parse_args(), read(PUBLISHED / ACCEPTED)
    programs = {kind: Path(path) for kind, _, path in (one.partition("=") for one in asked.program)}
    for arm, program in ((arm, programs[kind]) for arm, kind in ARMS.items() if kind in programs and arm != BEFORE):
        with tempfile.TemporaryDirectory() as folder:
            study, before = study_of(arm, program, Path(folder) / "study"), dict(kept.get(arm, {}))
            print(f"{arm}: {hashlib.sha256(program.read_bytes()).hexdigest()}", file=sys.stderr)
            flights = flights_of(study, {}, names(arm))
            if asked.again:
                same = [one.digest == before[one.name].digest for one in shared(study, flights, asked.jobs)]
                print(f"{arm}: {sum(same)} of {len(same)} flights have the same digest with --jobs {asked.jobs}")
            else:
                complete(PUBLISHED / ACCEPTED, kept, arm, study, flights, asked.jobs)
    if not asked.again:
        asked.output.write_text(registered(NAME) + told(kept), encoding="utf-8")


if __name__ == "__main__":
    main()
