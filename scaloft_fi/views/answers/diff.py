"""What `diff` answers."""

from __future__ import annotations

from scaloft_fi.errors import InputError
from scaloft_fi.study import Study
from scaloft_fi.views.flights.compare import DIFF, compare, comparison_table, comparison_values
from scaloft_fi.views.outputs.answer import Answer
from scaloft_fi.views.snapshot import snapshot


def diff(study: Study, first: str, second: str) -> Answer:
    """The flights of which two campaigns do not say the same.

    Raises:
        InputError: there is no such campaign, or the two were flown over different grids.
    """
    with snapshot(study, first) as here, snapshot(study, second) as there:
        if here.study.grid.name != there.study.grid.name:
            grids = f"{first!r} was flown over grid {here.study.grid.name!r}, {second!r} over {there.study.grid.name!r}"
            raise InputError(f"campaign {grids}; only campaigns of one grid have the same flights")
        compared = compare(here.latest, there.latest, here.study.roster, here.study.space)
    return Answer(
        DIFF,
        lambda: comparison_values(compared, first, second),
        lambda: (comparison_table(compared, first, second),),
    )
