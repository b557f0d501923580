"""One entry of the deviation matrix, and the faults that make it real."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

Value = float | str | bool
Rung = float | str

PHASE_SHARES = (0.0, 0.25, 0.5, 0.75)
"""By which shares of its period the catalogue shifts a periodic fault."""

PERIODS = ("period_s", "at_s")
"""Arguments a phase is a share of: the time after which a fault recurs, or at which it strikes once [s]."""


class CellStatus(StrEnum):
    """What the study says of a cell."""

    CREDIBLE = "credible"
    CONTROL = "control"
    NOT_MEANINGFUL = "not_meaningful"


@dataclass(frozen=True)
class Magnitude:
    """The ladder of a fault: how much, in the unit an engineer says it in.

    Attributes:
        argument: the operator's argument it sets.
        unit: what a number of the ladder is measured in, as in a mutant's id; empty for a name or a bare number.
        ladder: the catalogue's magnitudes, in the order of the study.
        default: the one a bare cell name stands for.
        scale: the operator's argument is scale x magnitude (5 ms: 0.001; 2 EV under-exposed: -1).
        worse: `larger`, `smaller` or `unordered`, where the order of the ladder does not tell it; else empty.
        neutral: the magnitude at which nothing is wrong, where the unit does not tell it; else None.
        place: file:line.
    """

    argument: str
    unit: str
    ladder: tuple[Rung, ...]
    default: Rung
    scale: float = 1.0
    worse: str = ""
    neutral: float | None = None
    place: str = field(default="", compare=False)

    def text(self, rung: Rung) -> str:
        """Write the magnitude as it stands in a mutant's id.

        >>> Magnitude("delay_s", "ms", (5.0, 20.0), 20.0, 0.001).text(20.0)
        '20ms'
        """
        return rung if isinstance(rung, str) else f"{rung:g}{self.unit}"

    def value(self, rung: Rung) -> Rung:
        """Return what the operator's argument becomes; twelve digits, so that 70 % is 0.7.

        >>> Magnitude("share", "%", (70.0,), 70.0, 0.01).value(70.0)
        0.7
        """
        return rung if isinstance(rung, str) else float(f"{rung * self.scale:.12g}")


@dataclass(frozen=True)
class Expected:
    """What is known beforehand: this fault alters nothing in the reference grid.

    Attributes:
        reason: why.
        magnitudes: the rungs it is known of; empty means all.
        status: the rung of the outcome, always `not_infected` (a seam that carries nothing is not infected either).
        place: file:line.
    """

    reason: str
    magnitudes: tuple[Rung, ...] = ()
    status: str = "not_infected"
    place: str = field(default="", compare=False)

    def holds_for(self, rung: Rung | None) -> bool:
        """Whether it speaks of this magnitude (None where the fault has no ladder)."""
        return not self.magnitudes or rung in self.magnitudes


@dataclass(frozen=True)
class Fault:
    """How a deviation is made: an operator at a seam.

    Attributes:
        seam: where it is patched in.
        operator: the declared function that alters the samples.
        message: type of the samples; None where the stack's seams were not at hand.
        arguments: the operator's fixed arguments.
        magnitude: the argument that varies, or None.
        phases: True for a periodic fault, which the catalogue also flies shifted in time.
        expected: what is known beforehand, or None.
        place: file:line of the fault.
        places: file:line of `seam`, `operator`, `phases` and each argument.
    """

    seam: str
    operator: str
    arguments: Mapping[str, Value] = field(default_factory=dict)
    magnitude: Magnitude | None = None
    phases: bool = False
    expected: Expected | None = None
    message: type | None = field(default=None, compare=False)
    place: str = field(default="", compare=False)
    places: Mapping[str, str] = field(default_factory=dict, compare=False, repr=False)

    def place_of(self, name: str) -> str:
        """Tell where `seam`, `operator`, `phases` or an argument stands, or else the fault itself."""
        if self.magnitude is not None and name == self.magnitude.argument:
            return self.magnitude.place
        return self.places.get(name, self.place)

    @property
    def rungs(self) -> tuple[Rung | None, ...]:
        """The ladder, or a single None where there is none."""
        return self.magnitude.ladder if self.magnitude else (None,)

    def period_s(self, rung: Rung | None) -> float | None:
        """Return the time after which the fault recurs, or at which it strikes once [s]; None without phases."""
        if not self.phases:
            return None
        values = dict(self.arguments)
        if self.magnitude is not None and rung is not None:
            values[self.magnitude.argument] = self.magnitude.value(rung)
        return next((float(values[name]) for name in PERIODS if name in values), None)

    def expects(self, rung: Rung | None) -> Expected | None:
        """Return what is known beforehand at this magnitude."""
        return self.expected if self.expected is not None and self.expected.holds_for(rung) else None


@dataclass(frozen=True)
class Cell:
    """One guideword asked of one parameter.

    Attributes:
        guideword, parameter: the ids it stands under.
        status: credible, a control, or not meaningful.
        deviation: what differs from the design intent (empty when not meaningful, as all below).
        causes: what could bring it about in this stack.
        effect: what it does locally, then to the flight.
        requirements: names of the requirements at risk.
        faults: how it is made; the first is the default.
        reason: why it is not meaningful (empty otherwise).
        predicted: what the study expects of it, free text.
        place: file:line of the cell.
        requirements_place: file:line of the requirements.
    """

    guideword: str
    parameter: str
    status: CellStatus
    deviation: str = ""
    causes: tuple[str, ...] = ()
    effect: str = ""
    requirements: tuple[str, ...] = ()
    faults: tuple[Fault, ...] = ()
    reason: str = ""
    predicted: str = ""
    place: str = field(default="", compare=False)
    requirements_place: str = field(default="", compare=False)

    @property
    def name(self) -> str:
        """`GUIDEWORD-parameter`, the stem of its mutants' ids."""
        return f"{self.guideword}-{self.parameter}"

    @property
    def told(self) -> str:
        """The deviation, or why there is none."""
        return self.deviation or self.reason

    @property
    def default_magnitude(self) -> str:
        """The default's magnitude as it stands in the mutant's id; empty where there is no ladder."""
        magnitude = self.faults[0].magnitude if self.faults else None
        return magnitude.text(magnitude.default) if magnitude else ""

    def mutant_ids(self, fault: Fault, rung: Rung | None) -> tuple[str, ...]:
        """Return the canonical ids of `fault` at this magnitude, one for each phase of the catalogue, phase 0 first.

        >>> pulse = Fault("collision", "false_flag", {}, Magnitude("period_s", "s", (20.0,), 20.0), phases=True)
        >>> Cell("UNINTENDED", "collision", CellStatus.CREDIBLE).mutant_ids(pulse, 20.0)[:2]
        ('UNINTENDED-collision@20s', 'UNINTENDED-collision@20s#5s')
        """
        stem = self.name if fault.magnitude is None or rung is None else f"{self.name}@{fault.magnitude.text(rung)}"
        period_s = fault.period_s(rung)
        shifts = () if period_s is None else tuple(share * period_s for share in PHASE_SHARES if share)
        return (stem, *(f"{stem}#{shift_s:g}s" for shift_s in shifts))
