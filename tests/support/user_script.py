"""A script as a user writes it; `mypy --strict` reads it, nobody runs it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, assert_type

from numpy.typing import NDArray

import scaloft_fi


def best(folder: str) -> float:
    """The mutation score of a campaign that is flown for it."""
    study = scaloft_fi.open(folder, grid=None)
    assert_type(study, scaloft_fi.OpenStudy)
    flight = study.fly("LATE-human", "T0O0W0D0H1", seed=0)
    assert_type(flight.status, str)
    assert_type(flight.log["x_m"], NDArray[Any])
    assert_type(flight.log.units["x_m"], str)
    flight.map().save("flight.svg")
    campaign = study.campaign("mine")
    score = campaign.run(mutants=["LATE-human"], situations="T0*", seeds=3, jobs=2, progress=print)
    assert_type(score.mutation_score, scaloft_fi.Ratio)
    assert_type(score.mutation_score.value, float | None)
    assert_type(campaign.flights().rows, int)
    kills = campaign.kills("LATE-human", show="survivors")
    assert_type(kills, scaloft_fi.Answer)
    assert_type(kills["survivors"], scaloft_fi.Columns)
    assert_type(campaign.worksheet().save("sheet.xlsx"), Path)
    assert_type(study.judge("flight.csv").warnings, tuple[str, ...])
    try:
        campaign.score(baseline_from="other")
    except scaloft_fi.InputError as error:
        raise SystemExit(error.exit_code) from error
    return score.mutation_score.value or 0.0
