"""The origin of an outcome: hashes of everything that can change it, part by part; the fingerprint of a platform."""

from __future__ import annotations

import ctypes
import hashlib
import platform
from collections.abc import Mapping
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from scaloft_fi.defaults import __version__

NUMERIC = ("numpy", "numba", "llvmlite", "filterpy", "scipy", "pybullet")
"""Packages whose versions can change the last bit of a flight or a reading."""
BRING_OPENBLAS = ("numpy", "scipy")
"""Packages whose wheels contain an OpenBLAS, in a folder `<package>.libs` beside the package."""
DECIDES = {
    "system": "yes, by its libraries",
    "machine": "yes, by its instructions",
    "processor": "yes: numba compiles for it, and OpenBLAS chooses its kernels by it",
    "libc": "yes: sines, roots and exponentials",
    "python": "yes: sums and mathematical functions",
    "scaloft-fi": "no: the hash of its code is part of each flight's key",
    "numpy": "yes",
    "numba": "yes: the compiled kernels",
    "llvmlite": "yes: the compiled kernels",
    "filterpy": "yes: the covariance of the filter",
    "scipy": "yes",
    "pybullet": "yes: rigid bodies and contacts",
    "numpy kernels": "yes: the order of additions in a product",
    "scipy kernels": "yes: the order of additions in a product",
}
"""Whether each part of a fingerprint decides the bits of a flight."""
CORE_NAMES = tuple(f"{prefix}openblas_get_corename{suffix}" for prefix in ("scipy_", "") for suffix in ("64_", ""))
"""Possible names of OpenBLAS's function for the name of its kernels; the name depends on the build."""


def fingerprint() -> dict[str, str]:
    """Platform and versions, by name."""
    facts = {
        "system": platform.system(),
        "machine": platform.machine(),
        "processor": _processor(),
        "libc": "-".join(platform.libc_ver()),
        "python": platform.python_version(),
        "scaloft-fi": __version__,
    }
    versions = {name: _version(name) for name in NUMERIC}
    return facts | versions | {f"{package} kernels": _kernels(package) for package in BRING_OPENBLAS}


def differences(ours: Mapping[str, str], theirs: Mapping[str, str], words: str = "{} {} here, {} there") -> list[str]:
    """The differences, each as `numpy 2.4.6 here, 1.26.4 there`, or in other `words`."""
    return [
        words.format(name, ours.get(name, "none"), theirs.get(name, "none"))
        for name in sorted(ours.keys() | theirs.keys())
        if ours.get(name) != theirs.get(name)
    ]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "none"


def _kernels(package: str) -> str:
    """The name of OpenBLAS's kernels in this process; "unknown" for another library.

    Kernels differ in the order of additions, which decides the last bit of a product.  This function loads the library
    without importing the package, because the import would dominate the time of a verb that only reads.
    """
    spec = find_spec(package)
    folders = [Path(place).with_name(f"{package}.libs") for place in (spec and spec.submodule_search_locations) or ()]
    with suppress(OSError, StopIteration):
        library = ctypes.CDLL(str(next(path for folder in folders for path in sorted(folder.glob("*openblas*.so*")))))
        for name in CORE_NAMES:
            with suppress(AttributeError):
                function = getattr(library, name)
                function.restype = ctypes.c_char_p
                return bytes(function()).decode()
    return "unknown"


def _processor() -> str:
    """The model of the processor, which decides the compiled instructions."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next(
        (line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.processor()
    )


class Origin(NamedTuple):
    """Hashes of the parts; empty for a part that does not affect the flight.

    Attributes:
        sim: the documents of `sim/` that decide every flight.
        requirements: the requirements.
        code: the modules that fly and judge every flight.
        mutant: the mutant; empty for the baseline.
        situation: the values that the situation sets in the world.
        realised: for a baseline, the predicates of the situation's values.
        operator: for a mutant, the modules that only its operator needs.
        platform: not a hash: differences of an earlier platform that made a stale flight; empty for other flights.
    """

    sim: str
    requirements: str
    code: str
    mutant: str
    situation: str
    realised: str = ""
    operator: str = ""
    platform: str = ""

    def key(self, seed: int) -> str:
        """The key of the flight with this seed."""
        parts = [f"{name}={value}" for name, value in zip(self._fields, self, strict=True) if value]
        return hashlib.sha256("\n".join([*parts, f"seed={seed}"]).encode()).hexdigest()

    def changed(self, now: Origin) -> tuple[str, ...]:
        """Names of the parts that differ in `now`."""
        return tuple(name for name in self._fields if getattr(self, name) != getattr(now, name))
