"""The hooks that make pages of the site do what their examples say."""

from __future__ import annotations

import doctest
import sys
from importlib import import_module
from pathlib import Path

import pytest

HOOKS = Path(__file__).resolve().parents[2] / "docs" / "hooks"


@pytest.mark.parametrize("name", sorted(path.stem for path in HOOKS.glob("*.py")))
def test_its_examples_hold(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for needed in ("mkdocs", "griffe"):
        pytest.importorskip(needed)
    monkeypatch.syspath_prepend(str(HOOKS))
    assert doctest.testmod(import_module(name)).failed == 0
    assert Path(str(sys.modules[name].__file__)).parent == HOOKS
