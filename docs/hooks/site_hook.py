"""The hook of mkdocs: adds pages that code and other files of the repository give, and names the files of blocks."""

from __future__ import annotations

import re
from typing import Any

from mkdocs.structure.files import File
from site_included import PICTURES, included_pages
from site_reference import reference_pages

_BLOCK = re.compile(r"^```(\w+) (file|update)=(\S+)$", re.MULTILINE)
_SAYS = {"file": "", "update": ": these entries"}


def on_files(files: Any, config: Any) -> Any:
    """Add the pages that are not written in `docs/`, and their pictures."""
    for path, text in {**reference_pages(), **included_pages()}.items():
        files.append(File.generated(config, path, content=text))
    for path, source in PICTURES.items():
        files.append(File.generated(config, path, abs_src_path=str(source)))
    return files


def on_page_markdown(markdown: str, **_page: Any) -> str:
    """The title of a block is the file that it belongs to.

    >>> on_page_markdown("```yaml update=sim/world.yaml")
    '```yaml title="sim/world.yaml: these entries"'
    """
    return _BLOCK.sub(lambda block: f'```{block[1]} title="{block[3]}{_SAYS[block[2]]}"', markdown)
