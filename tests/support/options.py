"""How the tests are asked to run: with `--release` they do more, with `RECORD=1` they write what is recorded anew."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import pytest
import yaml

T = TypeVar("T")


@dataclass
class Effort:
    """Set once, before any test is read."""

    release: bool = False


EFFORT = Effort()


def usually(some: T, *, release: T) -> T:
    """`some` in every run, `release` before a release."""
    return release if EFFORT.release else some


def cases(*names: str) -> Callable[[T], T]:
    """Run a test once for each of its cases, which stand under its name in `TEST.yaml`, beside the file of the test."""

    def mark(test: T) -> T:
        listed = _cases(Path(inspect.getfile(test)).with_suffix(".yaml"))[test.__name__]  # type: ignore
        return pytest.mark.parametrize(names if len(names) > 1 else names[0], listed)(test)

    return mark


@lru_cache
def _cases(path: Path) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = yaml.safe_load(path.read_text(encoding="utf-8"))
    return found


def as_recorded(test: str, texts: Mapping[str, str]) -> None:
    """Hold texts by name against `TEST.txt`, beside the file of a test."""
    path = Path(test).with_suffix(".txt")
    said = "\n".join(f"# {name}\n{text.rstrip()}\n" for name, text in texts.items())
    if os.environ.get("RECORD"):
        path.write_text(said, encoding="utf-8")
    assert said.splitlines() == path.read_text(encoding="utf-8").splitlines(), "if it is right: RECORD=1"
