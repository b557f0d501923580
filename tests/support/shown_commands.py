"""The commands that README and the site show, with the output beside them."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
GUIDES = ("stack", "operator", "sensor_or_signal", "export_format", "choice_of_situations", "happening", "axis")
"""The pages that are followed from an empty folder, with the package and the study that they make there."""
PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md")))
_BLOCK = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_INLINE = re.compile(r"(?<!`)`(scaloft-fi [^`\n]+)`(?!`)")
_STEP = re.compile(r"^\s*- (?:run: )?((?:pip|scaloft-fi) .+)$", re.MULTILINE)
_PROGRAM = re.compile(r"^(scaloft-fi|python\S*|pip|mkdocs|dask|\S+/bin/\S+) ")


@dataclass(frozen=True)
class Shown:
    """A command and what a page shows below it, nothing where it shows no output."""

    page: str
    command: str
    output: str = ""

    def __str__(self) -> str:
        return f"{self.page}: {self.command}"

    @property
    def words(self) -> list[str]:
        """The words of the command, without its comment."""
        return shlex.split(self.command, comments=True)


def shown_commands() -> list[Shown]:
    """Every command of a block `console`, of a block that a comment marks, and of a step of continuous integration."""
    return [shown for path in PAGES for shown in _of_page(path)]


def named_commands() -> list[Shown]:
    """Every command that stands in a sentence or a table."""
    return [Shown(path.name, command) for path in PAGES for command in _INLINE.findall(_prose(path.read_text()))]


def stray_commands() -> list[Shown]:
    """Commands in blocks of another kind, where no test would find them."""
    return [
        Shown(path.name, line)
        for path in PAGES
        for language, text in _BLOCK.findall(path.read_text())
        for line in text.splitlines()
        if not language.startswith("console") and _PROGRAM.match(line) and not _is_marked(path, text)
    ]


def _of_page(path: Path) -> Iterator[Shown]:
    for language, text in _BLOCK.findall(path.read_text()):
        if language.startswith("console"):
            for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
                command, _, output = part.partition("\n")
                yield Shown(path.name, command, output)
        elif language.startswith("yaml"):
            yield from (Shown(path.name, command) for command in _STEP.findall(text))
        elif _is_marked(path, text):
            yield Shown(path.name, text.strip())


def _is_marked(path: Path, text: str) -> bool:
    """Whether a comment above the block says what it is for: README's two commands."""
    return bool(re.search(rf"^<!-- \w+ -->\n```\n{re.escape(text)}```$", path.read_text(), re.MULTILINE))


def _prose(text: str) -> str:
    return _BLOCK.sub("", text)


def update(path: Path, text: str) -> None:
    """Put the top-level entries of `text` into a YAML file, in place of those with the same key."""
    path.write_text("".join((_entries(path.read_text()) | _entries(text)).values()))


def _entries(text: str) -> dict[str, str]:
    """The top-level entries of a YAML file, each as it stands, by key."""
    return {entry.split(":")[0]: f"{entry.rstrip()}\n" for entry in re.split(r"^(?=\w+:)", text, flags=re.MULTILINE)}
