"""Which installed package a declared thing comes from."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import entry_points
from typing import Any

from scaloft_fi.registry import PLUGIN_GROUP

OWN = "scaloft-fi"


def package_of(made: Callable[..., Any] | str) -> str:
    """The package that declares what a function makes: a distribution with a plugin, else the module's first name.

    Args:
        made: the function, or the name of its module.
    """
    module = made if isinstance(made, str) else made.__module__
    first = module.partition(".")[0]
    if first == __name__.partition(".")[0]:
        return OWN
    named = {plugin.module.partition(".")[0]: plugin.dist for plugin in entry_points(group=PLUGIN_GROUP)}
    distribution = named.get(first)
    return distribution.name if distribution else first
