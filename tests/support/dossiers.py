"""Dossiers of campaigns made by hypothesis, in a study whose texts are hostile."""

from __future__ import annotations

from datetime import date

from builders import GRID, KINDS, ROSTER, campaigns, seeded
from hypothesis import strategies as st

from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.survivor import Disposition
from scaloft_fi.hazop.matrix import Cell, CellStatus, Guideword, Matrix, Parameter
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.requirement import Requirement
from scaloft_fi.study import NO_FINDS, KnownFinds
from scaloft_fi.verbs.export.dossier import Dossier

HOSTILE = "<script>alert('1')</script> \"&\" =cmd|' /C calc'!A0 ]]> 人 \\textbf{x} " + "long " * 60
WORDS, PARAMETERS = ("NO", "LATE", "MORE", "REVERSE"), ("human", "goal")
LINES = {(word, parameter): 3 + i for parameter in PARAMETERS for i, word in enumerate(WORDS)}

MATRIX = Matrix(
    guidewords=tuple(Guideword(word, word.lower(), "") for word in WORDS),
    parameters=tuple(Parameter(name, name, "", "", "") for name in PARAMETERS),
    cells={
        (word, name): Cell(
            word,
            name,
            CellStatus.CONTROL if word == "REVERSE" else CellStatus.CREDIBLE,
            deviation=f"{word} {name} {HOSTILE}",
            effect=HOSTILE,
            place=f"/elsewhere/hazop/matrix/{name}.yaml:{line}",
        )
        for (word, name), line in LINES.items()
    },
)
SOURCES = {f"hazop/matrix/{name}.yaml": "".join(f"line {i}\n" for i in range(20)) for name in PARAMETERS}


def dossier(
    outcomes: list[Outcome],
    finds: KnownFinds = NO_FINDS,
    dispositions: tuple[Disposition, ...] = (),
    today: date | None = None,
) -> Dossier:
    return Dossier(
        study="reference",
        campaign=HOSTILE,
        version="0",
        platform={"system": "Linux", "numpy": "2"},
        matrix=MATRIX,
        space=GRID,
        roster=ROSTER,
        requirements=tuple(Requirement(name, kind, "always(x > 0)", title=HOSTILE) for name, kind in KINDS.items()),
        outcomes=tuple(outcomes),
        spending=Spending(),
        sources=SOURCES,
        finds=finds,
        dispositions=dispositions,
        today=today,
    )


def dossiers() -> st.SearchStrategy[Dossier]:
    """Of campaigns without a pool, and with one."""
    return st.one_of(campaigns(), seeded()).map(dossier)
