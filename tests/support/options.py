"""How the tests are asked to run: with `--release` they do more, with `RECORD=1` they write what is recorded anew."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
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


def as_recorded(test: str, texts: Mapping[str, str]) -> None:
    """Hold texts by name against `TEST.txt`, beside the file of a test."""
    path = Path(test).with_suffix(".txt")
    said = "\n".join(f"# {name}\n{text.rstrip()}\n" for name, text in texts.items())
    if os.environ.get("RECORD"):
        path.write_text(said, encoding="utf-8")
    assert said.splitlines() == path.read_text(encoding="utf-8").splitlines(), "if it is right: RECORD=1"
