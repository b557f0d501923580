"""What people read of survivors and their dispositions."""

from __future__ import annotations

from datetime import date

from scaloft_fi.analysis.survivor import Disposition, Judged, Standing
from scaloft_fi.verbs.dispositions import complaint, disposition_table

LATE, DAY = "LATE-human@3s", date(2027, 1, 31)


def test_every_sentence_names_the_mutant_and_what_to_do() -> None:
    known = Disposition(LATE, "me", "why", DAY, ("D0",), "f.yaml:3")
    for state in Standing:
        judged = Judged(LATE, state, ("D0", "D1"), None if state is Standing.OPEN else known)
        assert LATE in complaint(judged)
        assert state is Standing.OPEN or "f.yaml:3" in complaint(judged)


def test_survivors_with_a_find_are_named_below_the_table() -> None:
    judged = (Judged(LATE, Standing.OPEN, ("D0",)), Judged("NO-human", Standing.OPEN, ("D0",)))
    *_, note = disposition_table(judged, [LATE, "MORE-goal"], "mine").notes
    survivors = "`scaloft-fi kills --campaign mine --show survivors`"
    assert note == f"A search found situations that show {LATE}; {survivors} says how to fly them."
    assert len(disposition_table(judged).notes) == 2
