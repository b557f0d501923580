from __future__ import annotations

from builders import ROSTER, subject_of

from scaloft_fi.analysis.roster import Roster
from scaloft_fi.hazop.matrix import Cell, CellStatus, Fault, Guideword, Magnitude, Matrix, Parameter


def test_a_roster_takes_the_default_of_each_credible_cell_from_the_matrix() -> None:
    fault = Fault("person", "delay", magnitude=Magnitude("delay_s", "s", (1.0, 3.0), 3.0))
    cells = {
        ("LATE", "human"): Cell("LATE", "human", CellStatus.CREDIBLE, faults=(fault,)),
        ("NO", "human"): Cell("NO", "human", CellStatus.CREDIBLE, faults=(Fault("person", "drop"),)),
        ("REVERSE", "human"): Cell("REVERSE", "human", CellStatus.CONTROL, faults=(Fault("person", "invert"),)),
        ("EARLY", "human"): Cell("EARLY", "human", CellStatus.NOT_MEANINGFUL, reason="none"),
    }
    words = tuple(Guideword(word, word, "") for word, _ in cells)
    roster = Roster.of(Matrix(words, (Parameter("human", "", "", "", ""),), cells), ["LATE-human@1s", "LATE-human@3s"])
    assert roster.defaults == {"LATE-human": "LATE-human@3s", "NO-human": "NO-human"}
    assert roster.controls == {"REVERSE-human"}
    assert roster.counts(subject_of("LATE-human@3s"))
    assert not roster.counts(subject_of("LATE-human@1s"))
    assert roster.is_control(subject_of("REVERSE-human"))


def test_a_magnitude_off_the_ladder_stands_after_those_of_its_cell() -> None:
    ids = ["MORE-goal@0.6m", "LATE-human@9s", "LATE-human@1s", "baseline"]
    assert sorted(ids, key=ROSTER.rank) == ["baseline", "LATE-human@1s", "LATE-human@9s", "MORE-goal@0.6m"]
