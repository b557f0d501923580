"""What the installed packages declare that documents may name; of the published schemas the package's own alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

from scaloft_fi.mutants.operator import Operator
from scaloft_fi.sim.happenings import HappeningKind
from scaloft_fi.sim.log import DeclaredSignal
from scaloft_fi.sim.sensors.sensor import SensorKind
from scaloft_fi.sim.world import Role
from scaloft_fi.stack.declaration import Declaration
from scaloft_fi.views.lists.origin import OWN, package_of

T = TypeVar("T")


@dataclass(frozen=True)
class Declared:
    """Declared things by name: operators, sensors, kinds of happenings, roles of bodies, optional signals, stacks.

    Attributes:
        seams: of one study, by name with who sends and who receives; empty where no study is meant.
    """

    operators: Mapping[str, Operator]
    sensors: Mapping[str, SensorKind]
    happenings: Mapping[str, HappeningKind]
    roles: Mapping[str, Role]
    signals: Mapping[str, DeclaredSignal]
    stacks: Mapping[str, Declaration]
    seams: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def everything(cls, *, own: bool = False) -> Declared:
        """What is declared now; `own` leaves out what other packages declare.

        The operators of the package's stacks are declared first.
        """
        import scaloft_fi.mutants.reference
        import scaloft_fi.outside.faults  # noqa: F401 - both declare operators
        from scaloft_fi.mutants.operators import OPERATORS
        from scaloft_fi.sim.happenings import HAPPENINGS
        from scaloft_fi.sim.load import STACKS
        from scaloft_fi.sim.log import SIGNALS
        from scaloft_fi.sim.sensors import SensorsConfig  # noqa: F401 - the sensors declare themselves
        from scaloft_fi.sim.sensors.sensor import SENSORS
        from scaloft_fi.sim.world import ROLES

        return cls(
            operators=_chosen(OPERATORS, lambda one: one.make, own=own),
            sensors=_chosen(SENSORS, lambda one: one.make, own=own),
            happenings=_chosen(HAPPENINGS, lambda one: one.read, own=own),
            roles={name: role for name, role in ROLES.items() if name in OWN_ROLES or not own},
            signals=_chosen(SIGNALS, lambda one: one.make, own=own),
            stacks=_chosen(STACKS, lambda one: one.make, own=own),
        )


OWN_ROLES = ("obstacle", "person", "structure")
"""Roles are data, which do not tell who declared them."""


def _chosen(entries: Mapping[str, T], maker: Callable[[T], Any], *, own: bool) -> dict[str, T]:
    """The entries by name, in the order of their names."""
    return {name: entries[name] for name in sorted(entries) if not own or package_of(maker(entries[name])) == OWN}
