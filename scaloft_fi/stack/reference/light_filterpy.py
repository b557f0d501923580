"""`filterpy` without `scipy.stats`, whose import takes as long as that of numba and which no flight of ours uses.

filterpy imports `scipy.stats` for the likelihoods of its filters.  Here it gets a stand-in, which imports the module
when one of its functions is called.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from types import ModuleType
from typing import Any

LATE = "scipy.stats"


class _Late:
    """Something of the late module, found when it is called."""

    def __init__(self, path: tuple[str, ...]) -> None:
        self._path = path

    def __getattr__(self, name: str) -> _Late:
        return _Late((*self._path, name))

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        if isinstance(sys.modules.get(LATE), _StandIn):
            return None  # filterpy asks while it is imported whether an argument is known, which it has been since 2014
        found: Any = import_module(LATE)
        for name in self._path:
            found = getattr(found, name)
        return found(*args, **kwargs)


class _StandIn(ModuleType):
    def __getattr__(self, name: str) -> _Late:
        return _Late((name,))


@contextmanager
def _stood_in() -> Iterator[None]:
    if LATE in sys.modules:
        yield
        return
    sys.modules[LATE] = _StandIn(LATE)
    try:
        yield
    finally:
        del sys.modules[LATE]


with _stood_in():
    from filterpy.kalman import KalmanFilter as KalmanFilter
