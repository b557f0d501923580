"""The screen that README shows is what the published flights of this run give."""

from __future__ import annotations

import re
from pathlib import Path

from published_flights import ROOT, outcomes

from scaloft_fi.analysis.coverage import coverage
from scaloft_fi.analysis.score import score
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.study import NO_FINDS, Study
from scaloft_fi.verbs.first_screen import first_screen, screen_text

MUTANT, CONTROL = "LATE-human@3s", ("REVERSE-velcmd", "T0O0W0D0H0")


def _flown() -> list[Outcome]:
    """What `run --mutant LATE-human` flies: one seed, ten of the baseline where the mutant infects, one control."""
    published = outcomes()
    mutant = [one for one in published if one.mutant == MUTANT and one.seed == 0]
    infected = {one.situation for one in mutant if one.altered}
    seeds = {key: range(10) if key in infected else range(1) for key in {one.situation for one in mutant}}
    return [
        *(one for one in published if one.mutant == BASELINE and one.seed in seeds[one.situation]),
        *mutant,
        *(one for one in published if (one.mutant, one.situation) == CONTROL and one.seed == 0),
    ]


def test_the_screen_is_that_of_the_published_flights() -> None:
    study, flown = Study.open(ROOT), _flown()
    scored = score(flown, study.roster, study.space)
    screen = first_screen(
        scored, study.roster, study.space, coverage(flown, study.space), lambda _mutant: None, finds=NO_FINDS
    )
    shown = re.search(r"^```\n(Shown .*?)^```$", (Path(ROOT) / "README.md").read_text(), re.MULTILINE | re.DOTALL)
    assert shown
    assert shown[1] == screen_text(screen)
