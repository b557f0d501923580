"""Fly drawn faults and the paper's three rows below four flight controls, and hold what they show side by side.

    python -m experiments.four_autopilots --fly ARM [--program PATH]     # one arm; stored flights are not flown again
    python -m experiments.four_autopilots                                # the page, from the published flights

Each arm is a study of its own under `results/campaigns/`, which git ignores: the reference study with the rotors of a
quad X and, below the companion, a firmware.  `--fly` writes the arm's archive into
`results/published/four_autopilots/`.  The programs are the user's: `autopilots.md` says which were flown.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import chdir
from pathlib import Path
from typing import NamedTuple

from experiments import PUBLISHED, ROOT
from experiments.operating_point import LIGHT
from experiments.pages import Row, blocks, registered, table
from experiments.reference import call, thin
from experiments.two_drones import counted, differences, figures
from scaloft_fi.analysis.score import MutantScore
from scaloft_fi.campaign.store.archive import MANIFEST
from scaloft_fi.hazop.load import FOLDERS
from scaloft_fi.hazop.matrix import CellStatus, Matrix
from scaloft_fi.mutants.catalogue import default_of
from scaloft_fi.streams import generator
from scaloft_fi.study import Study
from scaloft_fi.verbs.campaigns import compared_by
from scaloft_fi.verbs.export.dossier import archive_files
from scaloft_fi.verbs.new import PARAMETERS, firmware_files
from scaloft_fi.verbs.snapshot import snapshot

NAME = "four_autopilots"
PARAMETERS_DRAWN = frozenset(
    ("human", "collision", "depth", "exposure", "map", "goal", "pose", "velcmd", "waypoint", "speedlimit")
)
"""Of perception and navigation; the others are sensors of flight control, clocks and power."""
ROWS = ("LATE-human", "UNINTENDED-collision", "MORE-goal")
"""The paper's cells."""
DRAWN = 24


class Arm(NamedTuple):
    """A campaign.

    kind: of firmware; "" is our flight control.
    version: of the firmware, in words.
    seeds, pool: of the mutants, and of the baselines.
    """

    kind: str
    version: str = ""
    seeds: str = "0-0"
    pool: str = "0-9"


ARMS: Mapping[str, Arm] = {
    "ours": Arm(""),
    "again": Arm("", seeds="10-10", pool="10-19"),
    "betaflight": Arm("betaflight", "Betaflight 4.6.0 with USE_IMU_CALC"),
    "px4": Arm("px4", "PX4 1.15.0"),
    "ardupilot": Arm("ardupilot", "ArduPilot Copter 4.6-dev"),
}


def mutants(matrix: Matrix) -> list[str]:
    """The default mutants of the paper's cells, then those of the drawn cells in the order of the matrix."""
    credible = (cell for cell in matrix if cell.status is CellStatus.CREDIBLE)
    cells = {cell.name: cell for cell in credible if cell.parameter in PARAMETERS_DRAWN}
    others = [name for name in cells if name not in ROWS]
    chosen = generator(NAME, 0).choice(len(others), DRAWN, replace=False)
    return [default_of(cells[name]).id for name in (*ROWS, *(others[at] for at in sorted(chosen)))]


def study_of(arm: str, program: Path | None) -> Study:
    """The study of an arm, written anew beside what was flown in it.

    Args:
        arm: its name.
        program: the firmware's program; None for our flight control, or where nothing is flown.
    """
    kind, version, *_ = ARMS[arm]
    folder = ROOT / "results" / "campaigns" / f"{NAME}_{arm}"
    for name in FOLDERS:
        shutil.rmtree(folder / name, ignore_errors=True)
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("*.md", "found.yaml"))
    program = program or Path(kind or "none")
    of_firmware = firmware_files(kind or "betaflight", program)
    if kind:
        stack = named(of_firmware, program, version, folder)
        (folder / "sim/stack.yaml").write_bytes(re.sub(rb"\n  sensors: \[.*?\]", b"\n  sensors: []", stack))
        if PARAMETERS in of_firmware:
            (folder / PARAMETERS).parent.mkdir(exist_ok=True)
            (folder / PARAMETERS).write_bytes(of_firmware[PARAMETERS])
    else:
        text = (folder / "sim/stack.yaml").read_text(encoding="utf-8")
        (folder / "sim/stack.yaml").write_text(text.replace("spins: [1, 1, -1, -1]", "spins: [-1, -1, 1, 1]"))
    (folder / "sim/vehicle.yaml").write_bytes(of_firmware["sim/vehicle.yaml"])
    return Study.open(folder)


def named(files: Mapping[str, bytes], program: Path, version: str, folder: Path) -> bytes:
    """The settings of a firmware's stack, whose program is named by a link in the folder of the study."""
    link = folder / "programs"
    link.unlink(missing_ok=True)
    link.symlink_to(program.absolute().parent)
    text = files["sim/stack.yaml"].decode().replace("as built", version)
    return text.replace(json.dumps(str(program.absolute())), f"programs/{program.name}").encode()


def fly(arm: str, program: Path | None, jobs: str) -> None:
    """Fly what is missing of an arm, and write its archive."""
    study = study_of(arm, program)
    chosen = [word for id_ in mutants(study.matrix) for word in ("--mutant", id_)]
    where = [word for key in LIGHT for word in ("--situation", key)]
    how = ("--seeds", ARMS[arm].seeds, "--baseline-seeds", ARMS[arm].pool, "--jobs", jobs)
    fly_and_publish(study, PUBLISHED / NAME / arm, *chosen, *where, *how)


def fly_and_publish(study: Study, archive: Path, *words: str) -> None:
    """Fly what is missing of a campaign, named as its archive, by `run` with these words, and write the archive."""
    with chdir(study.folder):
        print(call("run", "--campaign", archive.name, *words).decode())
    for name, content in archive_files(study, archive.name, documents=True, kept=thin).items():
        (archive / name).parent.mkdir(parents=True, exist_ok=True)
        (archive / name).write_bytes(content)


def results(study: Study) -> str:
    """The section with the results: every fault below each flight control, then ours beside each of the others."""
    flown = [arm for arm in ARMS if (PUBLISHED / NAME / arm / MANIFEST).exists()]
    if flown[:1] != ["ours"]:
        return "\n## Flown\n\nNot yet.\n"
    return side_by_side(study, PUBLISHED / NAME, flown, mutants(study.matrix))


def side_by_side(study: Study, folder: Path, arms: Sequence[str], ids: Sequence[str]) -> str:
    """What each arm shows of each mutant, then the first arm beside each other one.

    Args:
        study: any study of the matrix.
        folder: of the archives, each named as its arm.
        arms: the arms, in order.
        ids: of the mutants, in the order of their rows.
    """
    scores, heads = {}, []
    for arm in arms:
        with snapshot(study, str(folder / arm)) as now:
            scores[arm] = {one.id: one for one in now.score.counted}
            heads.append(figures(now))
    rows = [(name, *(dict(one)[name] for one in heads)) for name, _ in heads[0]]
    parts: list[str | Iterator[str]] = ["## Flown", table(("", *arms), rows), "### Every fault"]
    parts += [
        "Verdict, and the situations where a violation of a safety requirement was seen, of those that test the fault.",
        table(("mutant", *arms), _faults(ids, scores)),
    ]
    for arm in arms[1:]:
        told, _, _ = compared_by(study, str(folder / arms[0]), str(folder / arm), flights=False)
        sections = (one.replace("### ", "#### ", 1) for one in differences(told.scores, arms[0], arm, arms[0], arm))
        parts += [f"### {arms[0]} beside {arm}", counted(told.scores).replace("  ", " "), *sections]
    return blocks(*parts)


def _faults(ids: Sequence[str], scores: Mapping[str, Mapping[str, MutantScore]]) -> Iterator[Row]:
    """Verdict of each mutant in each arm, and the situations where a violation was seen, of those that test it."""
    for id_ in ids:
        yield (id_, *(_told(own[id_]) if id_ in own else "-" for own in scores.values()))


def _told(one: MutantScore) -> str:
    if not one.tested:
        return one.verdict.words
    seen = f"{len(one.seen_in)}/{one.kill_rate.whole}"
    firm = ", firm" if one.firm else ""
    return f"**{one.verdict.words}**{firm}, {seen}" if one.detected else f"{one.verdict.words}, {seen}"


def main() -> None:
    """Fly where that is asked for, else write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fly", choices=ARMS, help="fly an arm, and publish its flights")
    parser.add_argument("--program", type=Path, help="the firmware's program")
    parser.add_argument("--jobs", default="2", help="number of processes")
    options = parser.parse_args()
    if options.fly:
        fly(options.fly, options.program, options.jobs)
    else:
        (PUBLISHED / f"{NAME}.md").write_text(registered(NAME) + results(Study.open(ROOT)), encoding="utf-8")


if __name__ == "__main__":
    main()
