"""Sentences and screens as they are recorded in a file beside a test: `RECORD=1 pytest TEST` writes it anew."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path


def as_recorded(test: str, texts: Mapping[str, str]) -> None:
    """Hold texts by name against `TEST.txt`, beside the file of a test."""
    path = Path(test).with_suffix(".txt")
    said = "\n".join(f"# {name}\n{text.rstrip()}\n" for name, text in texts.items())
    if os.environ.get("RECORD"):
        path.write_text(said, encoding="utf-8")
    assert said.splitlines() == path.read_text(encoding="utf-8").splitlines(), "if it is right: RECORD=1"
