"""On what a campaign was flown: bits are promised on one platform only."""

from __future__ import annotations

import ctypes
import platform
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

from scaloft_fi import __version__

NUMERIC = ("numpy", "numba", "llvmlite", "filterpy", "scipy", "pybullet", "rtamt")
"""Packages whose versions can move the last bit of a flight or a reading."""
BRING_OPENBLAS = ("numpy", "scipy")
"""Packages whose wheels bring an OpenBLAS of their own, in a folder `<package>.libs` beside the package."""
CORE_NAMES = tuple(f"{prefix}openblas_get_corename{suffix}" for prefix in ("scipy_", "") for suffix in ("64_", ""))
"""What OpenBLAS's function for the name of its kernels is called, depending on how it was built."""


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


def differences(ours: dict[str, str], theirs: dict[str, str]) -> list[str]:
    """What differs, each as `numpy 2.4.6 here, 1.26.4 there`."""
    return [
        f"{name} {ours.get(name, 'none')} here, {theirs.get(name, 'none')} there"
        for name in sorted(ours.keys() | theirs.keys())
        if ours.get(name) != theirs.get(name)
    ]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "none"


def _kernels(package: str) -> str:
    """The kernels that OpenBLAS chose for this processor, or was told to choose; "unknown" of another library.

    They add in an order of their own, and so decide the last bit of a product.  The library is asked without importing
    the package, which would take longer than all else that a verb does that only reads.
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
    """The processor's model, which picks the instructions compiled for it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next(
        (line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.processor()
    )
