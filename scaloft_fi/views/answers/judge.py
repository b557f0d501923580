"""What `judge` answers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from scaloft_fi.campaign.flights.command import judged_record, known_of, mapping_of
from scaloft_fi.study import Study
from scaloft_fi.views.flights.judged import JUDGE, judged_table, judged_values
from scaloft_fi.views.outputs.answer import Answer


def judge(study: Study, files: Sequence[Path], record: Path | None = None, situation: str | None = None) -> Answer:
    """What the study's requirements say of records of flights.

    Args:
        study: the study.
        files: the records.
        record: a file that says where the signals stand in them; by default the study's, else that of `replay`.
        situation: the situation that was flown, which has a route and a time limit; None when it is not known.

    Raises:
        InputError: a file or the mapping cannot be read, or there is no such situation.
    """
    mapping = mapping_of(study, record)
    known = known_of(study, study.grid.situation(situation) if situation else None)
    records = [judged_record(study, path, mapping, known) for path in files]
    return Answer(JUDGE, lambda: judged_values(records), lambda: (judged_table(records),))
