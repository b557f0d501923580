"""Operators on messages that only the reference stack has; its declaration names this package."""

from importlib import import_module
from pkgutil import iter_modules

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")  # by name: the keys of a mutant leave out the operators of others
