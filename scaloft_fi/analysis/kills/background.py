"""What the study knows of a mutant before any flight: its seam, what it threatens, what is expected, the next rung."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from scaloft_fi.hazop.matrix import Fault, Matrix, Worse, mild_to_strong, worse
from scaloft_fi.mutants.catalogue import realise, source_of


@dataclass(frozen=True)
class Background:
    """What is known of a mutant beforehand.

    Attributes:
        seam: where the fault is patched in.
        at_risk: requirements that the cell names.
        expected: why it is known to alter nothing in this grid; empty when that is not known.
        stronger: the canonical ids of the stronger rungs of its ladder, mildest first.
        laddered: whether the fault has a ladder with an order.
    """

    seam: str
    at_risk: tuple[str, ...] = ()
    expected: str = ""
    stronger: tuple[str, ...] = ()
    laddered: bool = False


def backgrounds(matrix: Matrix, ids: Iterable[str]) -> dict[str, Background]:
    """The background of each mutant.

    Raises:
        InputError: an id is none of the matrix's.
    """
    return {id_: _background(matrix, id_) for id_ in ids}


def _background(matrix: Matrix, id_: str) -> Background:
    mutant = realise(matrix, id_)
    cell = matrix.cell(mutant.cell)
    fault, rung = source_of(matrix, mutant)
    expected = fault.expects(rung)
    stronger = _stronger(fault, rung)
    return Background(
        seam=mutant.seam,
        at_risk=cell.requirements,
        expected=expected.reason if expected else "",
        stronger=tuple(cell.mutant_ids(fault, worse_rung)[0] for worse_rung in stronger),
        laddered=fault.magnitude is not None and worse(fault.magnitude) is not Worse.UNORDERED,
    )


def _stronger(fault: Fault, rung: float | str | None) -> list[float]:
    """The rungs of the ladder that are stronger than this one, mildest first; none where the ladder has no order."""
    if fault.magnitude is None or rung is None or isinstance(rung, str):
        return []
    sign = 1 if worse(fault.magnitude) is Worse.LARGER else -1
    return [other for other in mild_to_strong(fault.magnitude) if sign * other > sign * rung]
