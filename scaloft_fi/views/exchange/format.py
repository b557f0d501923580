"""Export formats by name: each is one declaration, a function of the dossier."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from scaloft_fi.console import json_text, printable
from scaloft_fi.registry import Registry
from scaloft_fi.views.exchange.dossier import Dossier

Content = str | bytes | Mapping[str, Any] | Sequence[Any]
"""What a format may give: a text, the bytes of a file, or plain JSON values."""
Made = TypeVar("Made", bound=Content)


@dataclass(frozen=True)
class ExportFormat:
    """A format that `scaloft-fi export` writes.

    Attributes:
        name: as `--format` takes it.
        summary: what it is, in half a sentence, for the help.
        make: gives a campaign's content from its dossier.
        text: whether it can be printed; a format that is no text needs `--output`.
    """

    name: str
    summary: str
    make: Callable[[Dossier], Content]
    text: bool = True

    def content(self, dossier: Dossier) -> bytes:
        """A campaign in this format, as the bytes of a file; a text is made printable, bytes are taken as they are."""
        made = self.make(dossier)
        if isinstance(made, bytes):
            return made
        if isinstance(made, str):
            return printable(made).encode()
        return f"{json_text(made, indent=2, letters=True)}\n".encode()


FORMATS: Registry[ExportFormat] = Registry("export format")
"""Every format, those of plugins too."""


def export_format(
    name: str, summary: str, *, text: bool = True
) -> Callable[[Callable[[Dossier], Made]], Callable[[Dossier], Made]]:
    """Declare the function below it as an export format.

    Args:
        name: as `--format` takes it.
        summary: what it is, in half a sentence, for the help.
        text: whether it can be printed.

    Raises:
        ValueError: the name is taken.
    """

    def declare(make: Callable[[Dossier], Made]) -> Callable[[Dossier], Made]:
        FORMATS.declare(name, ExportFormat(name, summary, make, text))
        return make

    return declare
