"""What `new` wrote."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.shape import text, texts

NEW = Output(
    "new",
    "1.0",
    "what was written into a new folder",
    {
        "folder": text("the new folder"),
        "kind": text("a study, or a plugin package with a study in its folder study/", ("study", "plugin")),
        "files": texts("the files, relative to the folder"),
        "next": texts("the commands to give next, quoted for a shell, in their order"),
    },
    rows="files",
)


def new_values(folder: Path, files: Iterable[str], commands: Sequence[str], *, plugin: bool) -> dict[str, Any]:
    """Plain JSON values of the form `NEW`."""
    kind = "plugin" if plugin else "study"
    return {"folder": str(folder), "kind": kind, "files": sorted(files), "next": list(commands)}
