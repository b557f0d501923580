"""Fly the HAZOP of a firmware's own seams, as `scaloft-fi new --firmware` writes it, on Betaflight and PX4.

    python -m experiments.firmware_matrix --fly KIND --program PATH   # one kind; stored flights are not flown again
    python -m experiments.firmware_matrix                             # the page, from the published flights

`--fly` writes the archive of a kind, with its study, into `results/published/firmware_matrix/`.
"""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path

from experiments import PUBLISHED, ROOT
from experiments.four_autopilots import ARMS, fly_and_publish, named
from scaloft_fi.study import Study
from scaloft_fi.verbs.new import firmware_files, write_new

NAME = "firmware_matrix"
KINDS = ("betaflight", "px4")
SITUATIONS = ("T0O0W0D0H0", "T0O0W0D0H1", "T1O1W1D0H0", "T1O1W1D0H1")
"""Straight ahead, and with a corner, an obstacle and the bar; each with nobody and with a person."""
SEEDS, POOL = "0-0", "0-9"


def study_of(kind: str, program: Path) -> Study:
    """The study that `scaloft-fi new` writes, written anew beside what was flown in it."""
    folder, files = ROOT / "results" / "campaigns" / f"{NAME}_{kind}", firmware_files(kind, program)
    flown = folder.with_name(f"{folder.name}_flown")
    if folder.exists():
        (folder / "results").rename(flown)
        shutil.rmtree(folder)
    write_new(folder, files)
    (folder / "sim/stack.yaml").write_bytes(named(files, program, ARMS[kind].version, folder))
    if flown.exists():
        flown.rename(folder / "results")
    return Study.open(folder)


def main() -> None:
    """Fly where that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fly", choices=KINDS, help="fly a kind, and publish its flights")
    parser.add_argument("--program", type=Path, help="the firmware's program")
    parser.add_argument("--jobs", default="2", help="number of processes")
    options = parser.parse_args()
    if options.fly:
        where = [word for key in SITUATIONS for word in ("--situation", key)]
        how = ("--seeds", SEEDS, "--baseline-seeds", POOL, "--jobs", options.jobs)
        fly_and_publish(study_of(options.fly, options.program), PUBLISHED / NAME / options.fly, *where, *how)


if __name__ == "__main__":
    main()
