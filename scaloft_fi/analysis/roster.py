"""Who counts: the default mutant of each credible cell, the controls, the order of all mutants; a part of a whole."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from scaloft_fi.hazop.matrix import CellStatus, Matrix, SeverityClass, cell_of
from scaloft_fi.judge.outcome import BASELINE, PLACEBO_ID, Subject
from scaloft_fi.registry import grouped


@dataclass(frozen=True)
class Ratio:
    """`part` of `whole`; 0 of 0 is not a number and prints as n/a.

    >>> str(Ratio(8, 15)), Ratio(8, 15).short, str(Ratio(0, 0))
    ('8/15 = 53 %', '8/15', '0/0 = n/a')

    Attributes:
        part: how many of them.
        whole: how many there are.
    """

    part: int
    whole: int

    def __post_init__(self) -> None:
        if not 0 <= self.part <= self.whole:
            raise ValueError(f"{self.part} of {self.whole} is no share")

    @property
    def value(self) -> float | None:
        """The share 0..1, None for 0 of 0."""
        return self.part / self.whole if self.whole else None

    @property
    def short(self) -> str:
        """Without the share, which part and whole say: `8/15`."""
        return f"{self.part}/{self.whole}"

    def __str__(self) -> str:
        return f"{self.short} = " + ("n/a" if self.value is None else f"{100 * self.value:.0f} %")


class OfSubject:
    """What is told of a subject beside what was found of it."""

    subject: Subject

    @property
    def id(self) -> str:
        """Canonical id."""
        return self.subject.id


@dataclass(frozen=True)
class Roster:
    """The study's mutants as the scores need them.

    Attributes:
        defaults: per credible cell (`LATE-human`), the canonical id of its default mutant.
        controls: names of the control cells.
        ids: the canonical ids in the catalogue's order.
        severities: class of each cell that has one, by the cell's name.
    """

    defaults: Mapping[str, str]
    controls: frozenset[str]
    ids: tuple[str, ...]
    severities: Mapping[str, SeverityClass] = field(default_factory=dict)

    @classmethod
    def of(cls, matrix: Matrix, ids: Iterable[str]) -> Roster:
        """The roster of a matrix and the ids of the catalogue derived from it."""
        cells = [(cell, cell.default_id) for cell in matrix]
        return cls(
            defaults={cell.name: id_ for cell, id_ in cells if cell.status is CellStatus.CREDIBLE},
            controls=frozenset(cell.name for cell, _ in cells if cell.status is CellStatus.CONTROL),
            ids=tuple(ids),
            severities=matrix.severities,
        )

    @cached_property
    def _places(self) -> Mapping[str, int]:
        return {id_: place for place, id_ in enumerate(self.ids)}

    @cached_property
    def _cells(self) -> Mapping[str, int]:
        """Place of each cell's first mutant."""
        return {cell: self._places[own[0]] for cell, own in grouped(self._places, cell_of).items()}

    def counts(self, subject: Subject) -> bool:
        """Whether the subject is the default mutant of a credible cell: those the ratios count."""
        return self.defaults.get(cell_of(subject.id)) == subject.id

    def is_control(self, subject: Subject) -> bool:
        """Whether the subject is made from a control cell."""
        return cell_of(subject.id) in self.controls

    def severity(self, id_: str) -> SeverityClass | None:
        """The class of the cell that a mutant is made from; None where it has none."""
        return self.severities.get(cell_of(id_))

    def rank(self, id_: str) -> tuple[int, int, int, str]:
        """Sort key: the baseline, PLACEBO, the catalogue; a magnitude off the ladder stands after its cell's."""
        if id_ == BASELINE:
            return 0, 0, 0, ""
        if id_ == PLACEBO_ID:
            return 1, 0, 0, ""
        end = len(self.ids)
        return 2, self._cells.get(cell_of(id_), end), self._places.get(id_, end), id_
