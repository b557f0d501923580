"""Operators that fit any stack, one module for each kind of deviation; an import of this package declares them."""

from importlib import import_module
from pkgutil import iter_modules

from scaloft_fi.mutants.operator import OPERATORS

__all__ = ["OPERATORS"]

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")  # by name: the keys of a mutant leave out the operators of others
