"""A simulator of somebody else's: it flies one flight, injects the fault that it is told, and writes a table.

python fly.py --situation KEY --seed N --fault JSON --record FILE

Behind it is the simulator of this project, so that its verdicts can be held against those of the built-in flyer; but
nothing goes between the two except these words, the table, and the last line of output.  World and drone are those of
the study in which it is started.  Its table has columns, units and a clock of its own, which `sim/record.yaml` maps; a
record whose name does not end in .csv is a folder of rosbag2.
"""

import argparse
import csv
import json
import sys
from pathlib import Path

from scaloft_fi.campaign.flights.fly import Flight, wire_of
from scaloft_fi.mutants.mutant import Mutant
from scaloft_fi.sim.flight import fly
from scaloft_fi.sim.log import FlightLog
from scaloft_fi.study import Study

COLUMNS = {
    "x_m": "east",
    "y_m": "north",
    "z_m": "up",
    "speed_mps": "speed",
    "clearance_wall_m": "gap_wall",
    "clearance_ground_m": "gap_ground",
    "clearance_person_m": "gap_person",
    "clearance_obstacle_m": "gap_obstacle",
    "clearance_bar_m": "gap_bar",
    "person_sight_m": "person",
    "told_person": "seen",
    "told_range_m": "seen_at",
    "obstacle_pixels": "obstacle",
    "waypoint_wall_m": "wall",
    "light": "light",
    "landed": "down",
}
"""Column of the table by signal of the log."""


def write(path: Path, log: FlightLog) -> None:
    """Write the table; its clock is in milliseconds and began before the flight."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["clock_ms", *COLUMNS.values()])
        columns = [log.signals[name].tolist() for name in COLUMNS]
        for t_s, *values in zip(log.signals["elapsed_s"].tolist(), *columns, strict=True):
            writer.writerow([round(5000.0 + 1000.0 * t_s, 6), *values])


def main() -> None:
    """Fly once."""
    parser = argparse.ArgumentParser(description=__doc__)
    for word in ("--situation", "--fault", "--record"):
        parser.add_argument(word, required=True)
    parser.add_argument("--seed", type=int, required=True)
    words = parser.parse_args()
    study, fault = Study.open(), json.loads(words.fault)
    mutant = Mutant.from_json(fault) if fault else None
    flight = Flight(mutant, study.grid.situation(words.situation), words.seed)
    log = fly(study.sim, flight.situation, flight.seed, wire_of(study, flight), study.stack)
    if words.record.endswith(".csv"):
        write(Path(words.record), log)
    else:
        from bag import write_bag

        write_bag(Path(words.record), log, COLUMNS)
    counts = log.counts.values()
    first = [count.first_altered_s for count in counts if count.first_altered_s is not None]
    told = {
        "carried": sum(count.carried for count in counts),
        "altered": sum(count.altered for count in counts),
        "first_altered_s": min(first, default=None),
        "stack_error": log.stack_error,
    }
    sys.stdout.write(f"{json.dumps(told)}\n")


if __name__ == "__main__":
    main()
