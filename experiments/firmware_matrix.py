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
from experiments.four_autopilots import ARMS, fly_and_publish, named, side_by_side
from experiments.pages import registered
from scaloft_fi.campaign.store.archive import MANIFEST
from scaloft_fi.mutants.catalogue import defaults
from scaloft_fi.study import Study
from scaloft_fi.verbs.new import firmware_files, write_new

NAME = "firmware_matrix"
KINDS = ("betaflight", "px4")
SITUATIONS = ("T0O0W0D0H0", "T0O0W0D0H1", "T1O1W1D0H0", "T1O1W1D0H1")
"""Straight ahead, and with a corner, an obstacle and the bar; each with nobody and with a person."""
SEEDS = {"betaflight": ("0-0", "0-9"), "px4": ("20-20", "20-29")}
"""Seeds of the mutants, and of the pool."""


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


def results() -> str:
    """The section with the results: every fault on each firmware, then one beside the other."""
    folder = PUBLISHED / NAME
    flown = [kind for kind in KINDS if (folder / kind / MANIFEST).exists()]
    if not flown:
        return "\n## Flown\n\nNot yet.\n"
    studies = [Study.open(folder / kind) for kind in flown]
    ids = dict.fromkeys(mutant.id for study in reversed(studies) for mutant in defaults(study.matrix))
    return side_by_side(studies[0], folder, flown, [*ids])


def main() -> None:
    """Fly where that is asked for, else write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fly", choices=KINDS, help="fly a kind, and publish its flights")
    parser.add_argument("--program", type=Path, help="the firmware's program")
    parser.add_argument("--jobs", default="2", help="number of processes")
    options = parser.parse_args()
    if options.fly:
        where = [word for key in SITUATIONS for word in ("--situation", key)]
        seeds, pool = SEEDS[options.fly]
        how = ("--seeds", seeds, "--baseline-seeds", pool, "--jobs", options.jobs)
        fly_and_publish(study_of(options.fly, options.program), PUBLISHED / NAME / options.fly, *where, *how)
    else:
        (PUBLISHED / f"{NAME}.md").write_text(registered(NAME) + results(), encoding="utf-8")


if __name__ == "__main__":
    main()
