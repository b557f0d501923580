"""The enumerations whose values tables, screens, files of results or the report print."""

from __future__ import annotations

import importlib
import pkgutil
from enum import StrEnum

import scaloft_fi

FOLDERS = {"analysis", "campaign", "hazop", "judge", "sim", "verbs", "views"}
NOT_PRINTED = {
    "ColumnType": "types of columns for scripts",
    "Format": "a choice of an option",
    "Keep": "a key of YAML",
    "Likeness": "values of JSON, which the reference has",
    "Shape": "a key of YAML",
    "Side": "an order of signals",
    "Style": "codes of a terminal",
    "Worse": "an order of magnitudes",
    "scaloft_fi.stack.messages.Kind": "kinds of fields of messages",
}
"""The others, by name or by module and name, each with what it is."""


def printed_enumerations() -> list[type[StrEnum]]:
    """Every enumeration of texts in the package but those of `NOT_PRINTED`."""
    for module in pkgutil.walk_packages(scaloft_fi.__path__, "scaloft_fi."):
        if module.name.split(".")[1] in FOLDERS:
            importlib.import_module(module.name)
    ours = (one for one in StrEnum.__subclasses__() if one.__module__.startswith("scaloft_fi."))
    return [one for one in ours if not {one.__name__, f"{one.__module__}.{one.__name__}"} & set(NOT_PRINTED)]
