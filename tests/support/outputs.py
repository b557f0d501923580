"""What every verb that flies nothing prints, in every format, on two small campaigns.

`python tests/support/outputs.py` writes `outputs.json.gz`: exit code, output and messages of each command.
A test holds that they stay.  The campaigns are archives with their own study: four mutants in four situations of the
paper's grid with three seeds, and three mutants in four situations of the wide grid with one.
"""

from __future__ import annotations

import gzip
import hashlib
import json
import re
import sys
from collections.abc import Iterator
from contextlib import chdir
from pathlib import Path

from click.testing import CliRunner

from scaloft_fi.cli import main as scaloft_fi

ROOT = Path(__file__).resolve().parents[2]
RECORD = Path(__file__).with_name("outputs.json.gz")
CAMPAIGNS = {name: f"tests/support/campaigns/{name}.zip" for name in ("paper", "wide")}
"""By paths from the checkout, because the width of an absolute one decides where lines end."""
TABLES = ("table", "markdown", "csv", "json", "latex")
EXPORTS = ("csv", "gsn", "json", "junit", "markdown", "mutation-testing", "sace", "sace-json", "sarif")
OF_A_CAMPAIGN = (
    *(("score",), ("score", "--all"), ("score", "--by", "guideword"), ("score", "--by", "severity")),
    *(("kills", "--show", what) for what in ("conditions", "situations", "suite", "subsumption", "survivors")),
    *(("kills", "LATE-human"), ("worksheet",), ("coverage",), ("status",), ("dispositions",), ("matrix",)),
)
OF_A_STUDY = (
    *(("mutants", "LATE-*"), ("signals",), ("seams",), ("operators",)),
    *(("axes",), ("axes", "--grid", "wide"), ("map", "T1O1W1D1H1"), ("check",), ("seek", "--help"), ("run", "--help")),
)
OTHERS = (("--help",), ("score", "--format", "json", "--fail-under", "0.99"), ("score", "--fail-under-firm", "1"))
LONGEST = 20_000
"""Of longer outputs the record has the hash [characters]."""


def commands() -> Iterator[tuple[str, ...]]:
    """The commands, with `{paper}` and `{wide}` for the campaigns."""
    for name in CAMPAIGNS:
        here = ("--campaign", f"{{{name}}}")
        yield from ((*words, *here, "--format", style) for words in OF_A_CAMPAIGN for style in TABLES)
        yield from (("export", *here, "--format", style) for style in EXPORTS)
        yield from ((*words, *here) for words in OTHERS[1:])
    yield ("diff", "{paper}", "{wide}")
    for words in OF_A_STUDY:
        styles = ("table", "csv", "json") if words[0] == "check" else TABLES  # others write the path's signs otherwise
        yield from ((*words, *(("--format", style) if "--help" not in words else ())) for style in styles)
    yield OTHERS[0]


def printed(words: tuple[str, ...]) -> list[object]:
    """Exit code, output and messages of a command; of a long text the hash."""
    called = [word.format(**CAMPAIGNS) if word.startswith("{") else word for word in words]
    with chdir(ROOT):
        done = CliRunner().invoke(scaloft_fi, called)
    texts = (done.stdout, done.stderr)
    for name, path in CAMPAIGNS.items():
        texts = tuple(text.replace(path, f"{{{name}}}") for text in texts)
    if words[0] == "check":  # its columns are as wide as the path of the study
        texts = tuple(re.sub(r"  +|---+", " ", text) for text in texts)
    return [done.exit_code, *map(_short, texts)]


def _short(text: str) -> str:
    kept = text.replace(str(ROOT), "ROOT")
    return kept if len(kept) <= LONGEST else f"sha256 {hashlib.sha256(kept.encode()).hexdigest()}"


def recorded() -> dict[str, list[object]]:
    """The record, by command."""
    return json.loads(gzip.decompress(RECORD.read_bytes()))


def differences(every: int) -> tuple[int, list[str]]:
    """How many commands were tried, each `every`th of the record, and what is printed now where it differs."""
    record = recorded()
    asked = list(dict.fromkeys(commands()))
    assert [" ".join(words) for words in asked] == list(record), "the record is made by python tests/support/outputs.py"
    tried = {" ".join(words): printed(words) for words in asked[::every]}
    return len(tried), [
        f"{name}: {now}\nrecorded: {record[name]}" for name, now in tried.items() if now != record[name]
    ]


if __name__ == "__main__":
    if sys.argv[1:2] == ["check"]:
        count, differing = differences(int(sys.argv[2]))
        sys.stdout.write("\n".join([f"{count} commands tried", *differing, ""]))
        sys.exit(bool(differing))
    said = {" ".join(words): printed(words) for words in dict.fromkeys(commands())}
    RECORD.write_bytes(gzip.compress(json.dumps(said, indent=1).encode(), mtime=0))
