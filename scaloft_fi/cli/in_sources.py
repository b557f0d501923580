"""Names that packages declare, read from their sources: importing them takes too long for a key press."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from scaloft_fi.document import read_text

BELIEF, FORMAT, OPERATOR, SEAM, SIGNAL = "Belief", "@export_format", "@operator", "Seam", "@signal"
"""What a declaration begins with; its first argument is the name."""
OWN = Path(__file__).parents[1]
"""The sources of this package."""
MOST_FILES = 256
"""Most files of a plugin that are read."""


def declared(what: str, *folders: str) -> Iterator[str]:
    """The names that this package declares in some of its folders, then those that installed plugins declare.

    Args:
        what: one of the words above.
        folders: below this package.
    """
    indent = "" if what.startswith("@") else " *"  # an example in a docstring is indented
    name = re.compile(rf'^{indent}{what}\(\s*"([\w-]+)"', re.MULTILINE)
    own = (path for folder in folders for path in sorted((OWN / folder).rglob("*.py")))
    for path in (*own, *_plugins()):
        yield from name.findall(read_text(path))


def rows(pattern: str, file: str) -> list[str]:
    """What a pattern finds at the beginnings of the lines of a file of this package."""
    return re.findall(pattern, read_text(OWN / file), re.MULTILINE)


def _plugins() -> Iterator[Path]:
    """The sources of the packages that have plugins; none of them is imported."""
    from importlib.metadata import entry_points
    from importlib.util import find_spec

    from scaloft_fi.registry import PLUGIN_GROUP

    for top in sorted({plugin.module.partition(".")[0] for plugin in entry_points(group=PLUGIN_GROUP)}):
        spec = find_spec(top)
        if spec is not None and spec.submodule_search_locations is not None:
            for folder in spec.submodule_search_locations:
                yield from islice(sorted(Path(folder).rglob("*.py")), MOST_FILES)
        elif spec is not None and spec.origin is not None:
            yield Path(spec.origin)
