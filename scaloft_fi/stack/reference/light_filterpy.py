"""`filterpy` without the modules that take long to import and that no flight of ours uses.

filterpy imports `scipy.stats` for likelihoods and `scipy.ndimage` for its discrete filters; SciPy imports all that
NumPy has, its reader of Fortran too.  Here each is a stand-in, which imports its module when a function is called.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from types import ModuleType
from typing import Any

LATE = ("scipy.stats", "scipy.ndimage", "scipy.ndimage.filters", "scipy.ndimage.interpolation", "numpy.f2py")
"""The last two of `scipy.ndimage` are where filterpy 1.4.5 looks for what newer ones find in it."""


class _Late:
    """Something of a late module, found when it is called."""

    def __init__(self, module: str, path: tuple[str, ...]) -> None:
        self._module, self._path = module, path

    def __getattr__(self, name: str) -> _Late:
        return _Late(self._module, (*self._path, name))

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        if isinstance(sys.modules.get(self._module), _StandIn):
            return None  # filterpy asks while it is imported whether an argument is known, which it has been since 2014
        found: Any = import_module(self._module)
        for name in self._path:
            found = getattr(found, name)
        return found(*args, **kwargs)


class _StandIn(ModuleType):
    def __getattr__(self, name: str) -> _Late:
        return _Late(self.__name__, (name,))


@contextmanager
def _stood_in() -> Iterator[None]:
    """Stand-ins for the late modules that nobody has imported yet."""
    late = {name: _StandIn(name) for name in LATE if name not in sys.modules}
    sys.modules.update(late)
    places = [(import_module(package), module) for package, _, module in (name.rpartition(".") for name in late)]
    for (package, module), stand_in in zip(places, late.values(), strict=True):
        setattr(package, module, stand_in)
    try:
        yield
    finally:
        for name in late:
            del sys.modules[name]
        for package, module in places:
            delattr(package, module)


with _stood_in():
    from filterpy.kalman import KalmanFilter as KalmanFilter
    from scipy.linalg.lapack import dgesv as dgesv
