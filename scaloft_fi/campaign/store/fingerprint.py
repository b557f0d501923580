"""On what a campaign was flown: bits are promised on one platform only."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from scaloft_fi import __version__

NUMERIC = ("numpy", "numba", "llvmlite", "filterpy", "scipy", "pybullet", "rtamt")
"""Packages whose versions can move the last bit of a flight or a reading."""


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
    return facts | {name: _version(name) for name in NUMERIC}


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


def _processor() -> str:
    """The processor's model, which picks the instructions compiled for it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next(
        (line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.processor()
    )
