"""The hook of mkdocs: adds pages that code and other files of the repository give, and names the files of blocks."""

from __future__ import annotations

import re
from typing import Any

from mkdocs.structure.files import File
from site_included import PICTURES, included_pages, published_report
from site_reference import reference_pages

_BLOCK = re.compile(r"^```(\w+) (file|update|requirement)(?:=(\S+))?$", re.MULTILINE)
_SAYS = {"file": "", "update": ": these entries"}


def on_files(files: Any, config: Any) -> Any:
    """Add the pages that are not written in `docs/`, their pictures, and the report of the published campaign."""
    for path, text in [*reference_pages().items(), *included_pages().items(), published_report()]:
        files.append(File.generated(config, path, content=text))
    for path, source in PICTURES.items():
        files.append(File.generated(config, path, abs_src_path=str(source)))
    return files


def on_page_markdown(markdown: str, **_page: Any) -> str:
    """A block's title is the file that it belongs to; other words behind its language are for the tests.

    >>> on_page_markdown("```yaml update=sim/world.yaml")
    '```yaml title="sim/world.yaml: these entries"'
    >>> on_page_markdown("```yaml requirement")
    '```yaml'
    """
    return _BLOCK.sub(_head, markdown)


def _head(block: re.Match[str]) -> str:
    language, how, name = block.groups()
    return f'```{language} title="{name}{_SAYS[how]}"' if name else f"```{language}"
