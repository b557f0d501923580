"""Fault-injection mutation testing of an autonomous drone: HAZOP mutants flown over a grid of situations.

    import scaloft_fi

    study = scaloft_fi.open("my_study")
    flight = study.fly("LATE-human", "T0O0W0D0H1", seed=0)
    score = study.campaign().run(mutants=["LATE-human"], seeds=3)

`scaloft_fi.api` has what plugins need.
"""

from __future__ import annotations

from importlib import import_module

from scaloft_fi.defaults import __version__

TYPE_CHECKING = False
"""As `typing` has it, whose import takes twenty times as long as this package's; checkers of types take it for true."""
if TYPE_CHECKING:
    from scaloft_fi.analysis.roster import Ratio
    from scaloft_fi.campaign.workers import Interrupted
    from scaloft_fi.errors import GateError, InputError, ScaloftError
    from scaloft_fi.scripting.flight import Figure, FlownFlight, Log
    from scaloft_fi.scripting.study import CampaignScore, OpenCampaign, OpenStudy
    from scaloft_fi.scripting.study import open_study as open  # noqa: A004 - who writes `scaloft_fi.open` means this
    from scaloft_fi.verbs.worksheet import Worksheet
    from scaloft_fi.views.output import Answer, Columns, ColumnType

# a study, its campaigns and flights; what they answer; what they raise
__all__ = ["CampaignScore", "Figure", "FlownFlight", "Log", "OpenCampaign", "OpenStudy", "__version__", "open"]
__all__ += ["Answer", "ColumnType", "Columns", "Ratio", "Worksheet"]
__all__ += ["GateError", "InputError", "Interrupted", "ScaloftError"]

_LATE = {
    name: f"scaloft_fi.{module}"
    for module, names in {
        "analysis.roster": "Ratio",
        "campaign.workers": "Interrupted",
        "errors": "GateError InputError ScaloftError",
        "scripting.flight": "Figure FlownFlight Log",
        "scripting.study": "CampaignScore OpenCampaign OpenStudy open",
        "verbs.worksheet": "Worksheet",
        "views.output": "Answer ColumnType Columns",
    }.items()
    for name in names.split()
}
"""Where the names are; imported by whoever asks for one of them, so that a verb starts fast."""


def __getattr__(name: str) -> object:
    """A name of `_LATE`.

    Raises:
        AttributeError: there is none.
    """
    if name not in _LATE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_LATE[name]), "open_study" if name == "open" else name)


def __dir__() -> list[str]:
    """The public names, those too that nobody has asked for yet."""
    return sorted({*globals(), *__all__})
