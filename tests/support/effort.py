"""How much a test does: what every change can afford, or with `--release` all of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

T = TypeVar("T")


@dataclass
class Effort:
    """Set once, before any test is read."""

    release: bool = False


EFFORT = Effort()


def usually(some: T, *, release: T) -> T:
    """`some` in every run, `release` before a release."""
    return release if EFFORT.release else some
