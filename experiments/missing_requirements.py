"""Propose the requirement that is missing for every survivor of the reference campaign, and for the unmutated drone.

    python -m experiments.missing_requirements [--jobs N] [--output FILE]

What was found is kept beside the page, in `missing_requirements.json`; the same command makes the page from it.  Delete
the file to fly again.
"""

from __future__ import annotations

import experiments.published_kernels  # noqa: F401 - it must be imported before numpy

# isort: split

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments import PUBLISHED
from experiments.pages import Row, blocks, table, write
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.progress import Progress
from scaloft_fi.campaign.runs.propose import Sought, propose
from scaloft_fi.campaign.store.archive import study_of
from scaloft_fi.output import write_whole
from scaloft_fi.study import Study
from scaloft_fi.verbs.propose import PROPOSE, drawn, fresh_seeds, sought_in
from scaloft_fi.verbs.snapshot import snapshot

NAME = "missing_requirements"
CAMPAIGN = str(PUBLISHED / "reference")
SEEDS, SITUATIONS, REDRAWS, APART = 3, 8, 20, 100
"""Seeds of a subject in each half; its most situations; redraws of the unmutated drone; the distance of their seeds."""
PARTS = ("survivors", "redraws")


@dataclass(frozen=True)
class Redraw(Sought):
    """The unmutated drone with seeds that are `shift` further: nothing but chance tells it from itself."""

    shift: int

    def flights(self, study: Study, seeds: Sequence[int]) -> list[Flight]:
        """Its flights with these seeds."""
        return super().flights(study, [seed + self.shift for seed in seeds])


def found(jobs: int) -> dict[str, Any]:
    """What is proposed for the survivors of the campaign, and for the redraws."""
    with snapshot(study_of(PUBLISHED.parents[1], CAMPAIGN, None), CAMPAIGN) as now:
        survivors, seeds, study = sought_in(now, (), SITUATIONS), fresh_seeds(now, SEEDS), now.study
    keys = tuple(situation.key for situation in study.grid.situations)
    names = {f"redraw {number}": APART * number for number in range(1, REDRAWS + 1)}
    redraws = [Redraw(name, None, drawn(name, keys, SITUATIONS), shift) for name, shift in names.items()]
    told = {}
    arms: tuple[Sequence[Sought], ...] = (survivors, redraws)
    for part, sought in zip(PARTS, arms, strict=True):
        progress = Progress()
        told[part] = PROPOSE.record(propose(study, sought, seeds, jobs, progress))
        progress.close()
    return told


def results(_study: Study, jobs: int, folder: Path) -> str:
    """The section with the results, from what was found before or is found now."""
    kept = folder / f"{NAME}.json"
    if not kept.exists():
        write_whole(kept, json.dumps(found(jobs), indent=1).encode())
    told = json.loads(kept.read_bytes())
    survivors, redraws = (told[part] for part in PARTS)
    confirmed = [one for one in survivors["proposals"] if one["confirmed"]]
    firm = sum(one["firm"] for one in confirmed)
    shown = {one["mutant"] for one in confirmed} | {other for one in confirmed for other in one["others"]}
    wrong = sum(one["confirmed"] for one in redraws["proposals"])
    return blocks(
        "## Flown",
        f"**{len(confirmed)} of {_subjects(survivors)} survivors get a confirmed requirement, {firm} firmly** (without "
        f"any one seed too).  The confirmed ones together show {len(shown)} of them.  {len(survivors['same'])} equal "
        f"the unmutated drone to the bit, for {len(survivors['none'])} no candidate separates the flights, and "
        f"{len(survivors['proposals']) - len(confirmed)} were chosen and not confirmed.  Of {_subjects(redraws)} "
        f"redraws {len(redraws['proposals'])} get a choice, and **{wrong} are confirmed**.",
        "None of these candidates is a mean in a window, which `propose` tries too.",
        "### Survivors with a requirement",
        table(HEAD, map(_row, survivors["proposals"])),
        "### Survivors without one",
        f"No candidate separates the flights: {_listed(survivors['none'])}.",
        f"Equal to the bit: {_listed(survivors['same'])}.",
        "### Redraws",
        table(HEAD, map(_row, redraws["proposals"])) if redraws["proposals"] else "None gets a choice.",
    )


HEAD = ("mutant", "requirement", "shown in", "alarms", "p", "", "margin", "others")


def _row(one: Mapping[str, Any]) -> Row:
    state = "not confirmed" if not one["confirmed"] else "firm" if one["firm"] else "not firm"
    shown, alarms = (f"{one[name]['part']}/{one[name]['whole']}" for name in ("shown", "alarms"))
    title = one["title"].replace("|", "\\|")
    p, margin = f"{one['p']:.2g}", f"{one['margin']:.1f}"
    return one["mutant"], title, shown, alarms, p, state, margin, len(one["others"])


def _listed(ids: Sequence[str]) -> str:
    return ", ".join(ids) or "none"


def _subjects(told: Mapping[str, Any]) -> int:
    return sum(len(told[name]) for name in ("proposals", "same", "none"))


if __name__ == "__main__":
    write(__doc__, NAME, results)
