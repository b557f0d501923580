"""The kill matrix: mutants x situations of results, as one value that every picture and analysis reads."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from scaloft_fi.analysis.kills.gray import gray_order
from scaloft_fi.analysis.plain import plain
from scaloft_fi.analysis.ratio import Ratio
from scaloft_fi.analysis.roster import Roster
from scaloft_fi.analysis.scoring.detection import Verdict
from scaloft_fi.analysis.scoring.firmness import Firmness
from scaloft_fi.analysis.scoring.mutant_score import MutantScore, Result
from scaloft_fi.analysis.scoring.score import Score
from scaloft_fi.judge.outcome import Subject
from scaloft_fi.judge.space import Space
from scaloft_fi.judge.status import Status

NOT_FLOWN = "not_flown"
"""The state of a situation without a flight, beside the statuses."""


@dataclass(frozen=True)
class Entry:
    """A mutant in a situation.

    Attributes:
        situation: key.
        state: the furthest stage that a flight reached, or `not_flown`.
        kills: requirements that kill the mutant here, as the scores count.
        seen: safety requirements that put the fault to the test here and that a flight violates.
        tested: whether a safety requirement puts the fault to the test here.
        flown: flights that count.
        infected: whether the fault changed a sample in any.
        violated: per requirement, the flights that violate it, where any does.
    """

    situation: str
    state: str = NOT_FLOWN
    kills: tuple[str, ...] = ()
    seen: tuple[str, ...] = ()
    tested: bool = False
    flown: int = 0
    infected: bool = False
    violated: tuple[tuple[str, int], ...] = ()

    @property
    def survived(self) -> bool:
        """Whether it does not kill though the fault was tested, or could change nothing."""
        return not self.kills and (self.tested or (self.flown > 0 and not self.infected))


@dataclass(frozen=True)
class KillRow:
    """A mutant in every situation of the grid, and in every one with drawn numbers that was flown.

    Attributes:
        subject: the mutant.
        kind: `mutant`, `control` or `placebo`.
        counted: whether the ratios count it: the default mutant of a credible cell.
        status: the furthest stage that a flight reached.
        verdict: on the mutant.
        kill_rate: situations with a kill, of those that put it to the test.
        entries: in the grid's order; a situation that the grid does not have is left out.
        firmness: what remains of the verdict when one seed is left out; None where the mutant is not detected.
    """

    subject: Subject
    kind: str
    counted: bool
    status: Status
    verdict: Verdict
    kill_rate: Ratio
    entries: tuple[Entry, ...]
    firmness: Firmness | None = None

    @property
    def id(self) -> str:
        """Of the mutant."""
        return self.subject.id

    @property
    def killing(self) -> tuple[str, ...]:
        """Situations with a kill."""
        return tuple(entry.situation for entry in self.entries if entry.kills)

    @property
    def surviving(self) -> tuple[str, ...]:
        """Situations without one though the fault was tested, or could change nothing."""
        return tuple(entry.situation for entry in self.entries if entry.survived)

    @cached_property
    def kills(self) -> frozenset[str]:
        """Situations with a kill, as a set."""
        return frozenset(self.killing)


@dataclass(frozen=True)
class KillMatrix:
    """Mutants x situations.

    Attributes:
        space: the grid.
        rows: mutants in the canonical order, then controls, then PLACEBO.
    """

    space: Space
    rows: tuple[KillRow, ...]

    @cached_property
    def row(self) -> Mapping[str, KillRow]:
        """The row of each id."""
        return {row.id: row for row in self.rows}

    @property
    def mutants(self) -> tuple[KillRow, ...]:
        """Without controls and PLACEBO: what the analyses are about."""
        return tuple(row for row in self.rows if row.kind == "mutant")

    def only(self, ids: Collection[str]) -> KillMatrix:
        """The rows of these ids."""
        return KillMatrix(self.space, tuple(row for row in self.rows if row.id in ids))

    @cached_property
    def kills(self) -> Mapping[str, frozenset[str]]:
        """Per mutant with a kill its situations, as the scores count; controls and PLACEBO are not in it."""
        return {row.id: row.kills for row in self.mutants if row.kills}

    @property
    def scattered(self) -> tuple[str, ...]:
        """Detected mutants without a kill: some flights violate in several situations, most in none."""
        return tuple(row.id for row in self.mutants if row.verdict is Verdict.DETECTED and not row.kills)

    @property
    def not_firm(self) -> tuple[str, ...]:
        """Detected mutants whose verdict hangs on a seed, or that have too few seeds to say."""
        return tuple(row.id for row in self.mutants if row.firmness and not row.firmness.firm)

    @cached_property
    def flown(self) -> tuple[str, ...]:
        """Situations with a flight that counts, in the grid's order."""
        flown = {entry.situation for row in self.rows for entry in row.entries if entry.flown}
        return tuple(key for key, _ in self.space.situations if key in flown)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values: axes, situations in both orders, per mutant its entries in the grid's order."""
        space = self.space
        return {
            "axes": [
                {"id": axis, "values": [{"id": v, "word": w} for v, w in zip(values, words, strict=True)]}
                for axis, values, words in zip(space.axes, space.values, space.words, strict=True)
            ],
            "situations": [{"key": key, "point": list(point)} for key, point in space.situations],
            "gray": list(gray_order(space)),
            "states": [*(status.value for status in Status), NOT_FLOWN],
            "mutants": [_row_json(row) for row in self.rows],
        }


def kill_matrix(scored: Score, roster: Roster, space: Space) -> KillMatrix:
    """The kill matrix of a campaign's score; the roster says which mutants the ratios count."""
    placebo = [scored.placebo] if scored.placebo else []
    groups = (("mutant", scored.mutants), ("control", scored.controls), ("placebo", placebo))
    space = space.holding({result.situation for _, members in groups for one in members for result in one.results})
    rows = [_row(mutant, kind, roster, space) for kind, members in groups for mutant in members]
    return KillMatrix(space, tuple(rows))


def _row(mutant: MutantScore, kind: str, roster: Roster, space: Space) -> KillRow:
    results = {result.situation: result for result in mutant.results}
    return KillRow(
        subject=mutant.subject,
        kind=kind,
        counted=kind == "mutant" and roster.counts(mutant.subject),
        status=mutant.status,
        verdict=mutant.verdict,
        kill_rate=mutant.kill_rate,
        entries=tuple(_entry(key, results.get(key)) for key, _ in space.situations),
        firmness=mutant.firmness,
    )


def _entry(key: str, result: Result | None) -> Entry:
    if result is None:
        return Entry(key)
    return Entry(
        situation=key,
        state=result.status.value,
        kills=result.kills,
        seen=result.seen,
        tested=result.tested,
        flown=result.flown,
        infected=result.infected,
        violated=result.violated,
    )


def _row_json(row: KillRow) -> dict[str, Any]:
    return {
        "id": row.id,
        "guideword": row.subject.guideword,
        "parameter": row.subject.parameter,
        "magnitude": row.subject.magnitude,
        "kind": row.kind,
        "counted": row.counted,
        "status": row.status.value,
        "verdict": row.verdict.value,
        "firm": row.firmness.value if row.firmness else None,
        "kill_rate": plain(row.kill_rate),
        "entries": [
            {
                "state": entry.state,
                "kills": list(entry.kills),
                "seen": list(entry.seen),
                "tested": entry.tested,
                "flown": entry.flown,
                "infected": entry.infected,
                "violated": dict(entry.violated),
            }
            for entry in row.entries
        ],
    }
