"""Pages of the site whose text lives elsewhere in the repository: published experiments, design, the study's files."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from posixpath import dirname, relpath

from scaloft_fi.study import Study
from scaloft_fi.verbs.report.analyses import gather
from scaloft_fi.verbs.report.page import page

ROOT = Path(__file__).resolve().parents[2]
PUBLISHED = ROOT / "results" / "published"
PICTURES = {
    "experiments/report.png": PUBLISHED / "report.png",
    "experiments/unintended.png": PUBLISHED / "unintended.png",
    "experiments/two_matrices.png": PUBLISHED / "two_matrices.png",
    "experiments/two_matrices.html": PUBLISHED / "two_matrices.html",
}
"""Pictures of these pages, and the comparison of the two drones, by their place in the site."""
REPORT = "reference/report.html"
"""The report of the published campaign, beside these pages."""
SECTIONS = {
    "how_it_works.md": (
        "How it works",
        ("Concepts, each with one name", "The way of the data", "What a stack declares", "Layout"),
    ),
    "decisions.md": ("Decisions and their reasons", ("Decisions and their reasons",)),
    "limits.md": ("Limits", ("Known weaknesses",)),
}
"""Pages of the site made of sections of DESIGN.md: title, sections."""
WHOLE = {
    "reference/hazop.md": "hazop/README.md",
    "reference/sim.md": "sim/README.md",
    "experiments/index.md": "results/published/README.md",
}
"""Pages of the site that are another file of the repository."""
ASIDE = "docs/further_decisions.md"
"""It is for who changes the code, and no page of the site."""


def included_pages() -> dict[str, str]:
    """The pages by their place in the site; each published experiment is a text to open, beside the page about all."""
    pages = {path: _linked((ROOT / source).read_text(), path) for path, source in WHOLE.items()}
    sections = _sections((ROOT / "DESIGN.md").read_text())
    for path, (title, names) in SECTIONS.items():
        only = len(names) == 1
        parts = [sections[name] if only else f"## {name}\n{sections[name]}" for name in names]
        pages[path] = _linked(f"# {title}\n\n" + "\n".join(parts), path)
    return pages | {_experiment(path): path.read_text() for path in sorted(PUBLISHED.glob("*.md"))}


def _experiment(source: Path) -> str:
    return f"experiments/{source.stem}.txt"


def published_report() -> tuple[str, str]:
    """The place of the report of the reference campaign in the site, and its text, made of the published flights."""
    evidence = gather(Study.open(ROOT), str(PUBLISHED / "reference"))
    return f"experiments/{REPORT}", page(evidence)


def _sections(text: str) -> Mapping[str, str]:
    """The text below each heading of the second level."""
    parts = re.split(r"^## (.+)$", text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def _linked(text: str, path: str) -> str:
    """The text with a link where it names a page of the site.

    >>> _linked("see `docs/stack.md`", "reference/sim.md")
    'see [`docs/stack.md`](../stack.md)'
    >>> _linked("see `found.md`", "experiments/index.md")
    'see [`found.md`](found.txt)'
    """

    def link(named: re.Match[str]) -> str:
        place = _place(named[1], path)
        return f"[{named[0]}]({relpath(place, dirname(path))})" if place and place != path else named[0]

    return re.sub(r"(?<!\[)`([\w./]+\.(?:md|html))`(?!\])", link, text)


def _place(named: str, path: str) -> str:
    """The place in the site of a file that a text names; empty when the site does not have it."""
    wholes = {source: place for place, source in WHOLE.items()}
    if named in wholes:
        return wholes[named]
    if named.startswith("docs/") and named != ASIDE and (ROOT / named).is_file():
        return named.removeprefix("docs/")
    if named == REPORT:
        return f"experiments/{REPORT}"
    published = PUBLISHED / named.removeprefix("results/published/")
    beside = path.startswith("experiments/") or named.startswith("results/published/")
    return _experiment(published) if beside and published.parent == PUBLISHED and published.is_file() else ""
