"""Progress of a run for scripts: nothing, lines on the standard error, or calls of a function."""

from __future__ import annotations

from collections.abc import Callable

from scaloft_fi.campaign.progress import Progress, Silence
from scaloft_fi.errors import InputError

Told = bool | Callable[[int, int], object]
"""True for lines on the standard error, or a function of the flights flown and expected so far; False for nothing."""


class Calls(Silence):
    """Calls a function after each flight.

    Args:
        tell: the function; its arguments are the number of flights flown and that of flights expected.
    """

    def __init__(self, tell: Callable[[int, int], object]) -> None:
        super().__init__()
        self._tell = tell

    def advance(self) -> None:
        """Count one more flight, and call the function."""
        super().advance()
        self._tell(self.done, self.flights)


def progress_of(told: Told) -> Progress:
    """The progress display for the argument `progress`.

    Raises:
        InputError: it is neither a truth value nor a function.
    """
    if isinstance(told, bool):
        return Progress() if told else Silence()
    if not callable(told):
        raise InputError(f"progress={told!r} must be True, False, or a function of two numbers")
    return Calls(told)
