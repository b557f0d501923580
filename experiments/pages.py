"""Pages of the experiments: the plan that was registered, blocks of Markdown, and what every script takes."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

from experiments import PUBLISHED, ROOT
from scaloft_fi.campaign.processes import cores
from scaloft_fi.study import Study

Row = Sequence[object]


def registered(name: str, begin: str = "", end: str = "\n## Flown") -> str:
    """The text of a published page from `begin` up to `end`; by default its plan, committed before the flights."""
    text = (PUBLISHED / f"{name}.md").read_text(encoding="utf-8")
    start = text.index(begin)
    return text[start : text.index(end, start)]


def table(head: Row, rows: Iterable[Row]) -> Iterator[str]:
    """The lines of a table."""
    first, *rest = (f"| {' | '.join(map(str, row))} |" for row in (head, *rows))
    return iter((first, "|" + "---|" * len(head), *rest))


def blocks(*parts: str | Iterable[str]) -> str:
    """Parts, each a text or its lines, with a blank line before each; what is empty is left out."""
    texts = (part if isinstance(part, str) else "\n".join(part) for part in parts)
    return "\n" + "\n\n".join(filter(None, texts)) + "\n"


def parser(about: str | None, name: str) -> argparse.ArgumentParser:
    """The options of a script with this docstring: where its page is written, and how many processes fly."""
    made = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--jobs", type=int, default=cores(), help="number of processes")
    page = PUBLISHED / f"{name}.md"
    made.add_argument("--output", type=Path, default=page, help="the page (default: published); files stand beside it")
    return made


def write(about: str | None, name: str, results: Callable[[Study, int, Path], str], end: str = "\n## Flown") -> None:
    """Write the page of a script: its plan, and what `results` says of the study.

    Args:
        about: docstring of the script.
        name: of the published page.
        results: flies with a number of processes; flights that are kept stand in the folder of the page.
        end: what of the published page comes behind its plan.
    """
    options = parser(about, name).parse_args()
    text = registered(name, end=end) + results(Study.open(ROOT), options.jobs, options.output.parent)
    options.output.write_text(text, encoding="utf-8")
