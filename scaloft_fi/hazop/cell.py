"""A cell of the deviation matrix, and the faults that produce its deviation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from scaloft_fi.hazop.name import Name

Value = float | str | bool
Rung = float | str

PHASE_SHARES = (0.0, 0.25, 0.5, 0.75)
"""Phases of a periodic fault in the catalogue, as shares of its period."""

PERIODS = ("period_s", "at_s")
"""Arguments that a phase is a share of: the period of a fault, or the moment of a fault that happens once [s]."""


class CellStatus(StrEnum):
    """How the study classifies a cell."""

    CREDIBLE = "credible"
    CONTROL = "control"
    NOT_MEANINGFUL = "not_meaningful"


@dataclass(frozen=True)
class Magnitude:
    """The magnitudes of a fault, in the unit that an engineer would use.

    Attributes:
        argument: the operator's argument that the magnitude sets.
        unit: of the ladder's numbers, as in a mutant's id; empty when the ladder has names or numbers without a unit.
        ladder: the magnitudes in the catalogue, in the order of the study.
        default: the magnitude that the name of the cell alone stands for.
        scale: the operator's argument is scale x magnitude (5 ms: 0.001; 2 EV under-exposed: -1).
        worse: which magnitudes are worse: `larger`, `smaller` or `unordered`; empty when the ladder's order shows it.
        neutral: the magnitude that changes nothing; None when it follows from the unit.
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
    """The expectation that a fault alters nothing in the reference grid.

    Attributes:
        reason: why the fault alters nothing.
        magnitudes: for which the expectation holds; empty means all.
        status: the expected status, always `not_infected` (which includes a seam that carries nothing).
        place: file:line.
    """

    reason: str
    magnitudes: tuple[Rung, ...] = ()
    status: str = "not_infected"
    place: str = field(default="", compare=False)

    def holds_for(self, rung: Rung | None) -> bool:
        """Whether the expectation holds for this magnitude (None when the fault has no ladder)."""
        return not self.magnitudes or rung in self.magnitudes


@dataclass(frozen=True)
class Fault:
    """A fault that produces a deviation: an operator at a seam.

    Attributes:
        seam: where the operator is patched in.
        operator: the declared function that alters the samples.
        message: type of the samples; None where the stack's seams were not at hand.
        arguments: the operator's fixed arguments.
        magnitude: the argument that varies, or None.
        phases: True for a fault that the catalogue also has at later phases of its period, and at events of the flight.
        events: of a fault with phases, by name of an event why it can come in no flight of the study; "" if it can.
        expected: the expectation about its status, or None.
        place: file:line of the fault.
        places: file:line of `seam`, `operator`, `phases` and each argument.
    """

    seam: str
    operator: str
    arguments: Mapping[str, Value] = field(default_factory=dict)
    magnitude: Magnitude | None = None
    phases: bool = False
    events: Mapping[str, str] = field(default_factory=dict, compare=False)
    expected: Expected | None = None
    message: type | None = field(default=None, compare=False)
    place: str = field(default="", compare=False)
    places: Mapping[str, str] = field(default_factory=dict, compare=False, repr=False)

    def place_of(self, name: str) -> str:
        """Return file:line of `seam`, `operator`, `phases` or an argument; of the fault when there is no such line."""
        if self.magnitude is not None and name == self.magnitude.argument:
            return self.magnitude.place
        return self.places.get(name, self.place)

    @property
    def rungs(self) -> tuple[Rung | None, ...]:
        """The ladder; a single None when the fault has no ladder."""
        return self.magnitude.ladder if self.magnitude else (None,)

    def phases_s(self, rung: Rung | None) -> tuple[float, ...]:
        """The catalogue's phases at this magnitude [s], 0 first; only 0 for a fault without phases."""
        period_s = self.period_s(rung)
        return (0.0,) if period_s is None else tuple(share * period_s for share in PHASE_SHARES)

    def events_of(self, rung: Rung | None) -> tuple[str, ...]:
        """The events at which the catalogue has the fault at this magnitude.

        Where the magnitude is the period, all magnitudes strike at the same occurrences or nearly so: the default does.
        """
        magnitude = self.magnitude
        if magnitude is not None and magnitude.argument in PERIODS and rung != magnitude.default:
            return ()
        return tuple(name for name, why_not in self.events.items() if not why_not)

    def period_s(self, rung: Rung | None) -> float | None:
        """Return the period of the fault, or the moment of a fault that happens once [s]; None without phases."""
        if not self.phases:
            return None
        values = dict(self.arguments)
        if self.magnitude is not None and rung is not None:
            values[self.magnitude.argument] = self.magnitude.value(rung)
        return next((float(values[name]) for name in PERIODS if name in values), None)

    def expects(self, rung: Rung | None) -> Expected | None:
        """Return the expectation that holds for this magnitude, or None."""
        return self.expected if self.expected is not None and self.expected.holds_for(rung) else None


@dataclass(frozen=True)
class Cell:
    """One guideword applied to one parameter.

    Attributes:
        guideword, parameter: their ids.
        status: credible, a control, or not meaningful.
        deviation: how the parameter differs from the design intent.  A cell that is not meaningful has no deviation,
            and its attributes below are empty too.
        causes: what could cause the deviation in this stack.
        effect: the local effect, then the effect on the flight.
        requirements: names of the requirements at risk.
        faults: the faults that produce the deviation; the first is the default.
        reason: why the cell is not meaningful (empty otherwise).
        predicted: the effect that the study predicts, free text.
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
        """The deviation, or the reason why there is none."""
        return self.deviation or self.reason

    @property
    def default_id(self) -> str:
        """Id of the mutant that the cell's bare name stands for."""
        return str(Name(self.guideword, self.parameter, self.default_magnitude))

    @property
    def default_magnitude(self) -> str:
        """The magnitude of the default mutant, as in its id; empty when the default fault has no ladder."""
        magnitude = self.faults[0].magnitude if self.faults else None
        return magnitude.text(magnitude.default) if magnitude else ""

    def mutant_ids(self, fault: Fault, rung: Rung | None) -> tuple[str, ...]:
        """Return the canonical ids of `fault` at this magnitude, one for each phase of the catalogue: 0, times, events.

        >>> pulse = Fault("collision", "false_flag", {}, Magnitude("period_s", "s", (20.0,), 20.0), phases=True)
        >>> Cell("UNINTENDED", "collision", CellStatus.CREDIBLE).mutant_ids(pulse, 20.0)[:2]
        ('UNINTENDED-collision@20s', 'UNINTENDED-collision@20s#5s')
        """
        magnitude = "" if fault.magnitude is None or rung is None else fault.magnitude.text(rung)
        phases = [(phase_s, "") for phase_s in fault.phases_s(rung)] + [(0.0, name) for name in fault.events_of(rung)]
        return tuple(str(Name(self.guideword, self.parameter, magnitude, *phase)) for phase in phases)
