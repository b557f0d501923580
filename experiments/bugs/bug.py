"""A bug: where it was found, what was wrong, what its fix changed, and the stages that have it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from experiments.bugs.staged import Parts


@dataclass(frozen=True)
class Bug:
    """A bug of a public project.

    Attributes:
        key: of the bug, and name of its stack, such as `px4-11866`.
        project: the repository.
        thread: address of the issue or pull request that tells it.
        fixed_by: issue or pull request that fixed it, or that says how.
        cell: the cell that reads like it.
        wrong: what was wrong, in a sentence.
        fix: what the fix changed, in a sentence.
        written: how it stands in the copy of the reference stack, in a sentence.
        parts: the stages; the defective ones have a class attribute `defect`.
    """

    key: str
    project: str
    thread: str
    fixed_by: str
    cell: str
    wrong: str
    fix: str
    written: str
    parts: Parts

    @property
    def mended(self) -> Parts:
        """The same stages with the defect off."""
        kinds: dict[str, Any] = {field.name: _mended(getattr(self.parts, field.name)) for field in fields(Parts)}
        return Parts(**kinds)


def _mended(kind: object) -> object:
    """The same class with its defect off; whatever has none, as it is."""
    if isinstance(kind, type) and hasattr(kind, "defect"):
        return type(kind.__name__, (kind,), {"defect": False})
    return kind
