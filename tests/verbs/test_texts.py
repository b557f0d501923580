"""Whatever a study and a store say, no verb lets a terminal, a spreadsheet or a reader of its output obey it."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
import yaml
from click.testing import Result
from options import usually
from paper_flyer import Whole
from papers import flight
from printed import Call, commands, invoked, obeyed
from studies import copied

from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.output import printable
from scaloft_fi.study import Study

EVIL = "=1+1|<b>x</b>\x1b[31m\x9b\x7f\u202e\u200b\x07 & % \\input{x} [l](javascript:1)"
MARKED = "=1+1|<b>x</b> & % \\input{x} [l](javascript:1)"
"""The same without control characters, which no store holds in the name of a body."""
_ANYWHERE = {"title", "intent", "meaning", "node", "category", "source"}
FREE = _ANYWHERE | {"deviation", "reason", "effect", "causes", "predicted"}
"""Keys of a study whose values are texts that nothing reads but people."""
FORMATS = ("table", "markdown", "csv", "json", "latex")
VERBS = commands(
    "matrix; matrix --grid; matrix --cell LATE-human; matrix --margins; mutants --cell LATE-human; signals; "
    "seams person; axes; axes T; status; score --all --by parameter; worksheet; dispositions; kills; coverage; "
    "diff"
)
EXPORTS = ("json", "csv", "gsn", "junit", "markdown", "mutation-testing", "sace", "sace-json", "sarif")


class Evil(Whole):
    """A flyer without physics, every text of whose outcomes is hostile."""

    def prepare(self, study: Study, say: Callable[[str], None]) -> None:
        say(EVIL)

    def __call__(self, study: Study, flown: Flight) -> Outcome:
        outcome = flight(study, flown.subject.id, flown.situation.key, flown.seed)
        struck = tuple(replace(violation, struck=f"{MARKED} wall") for violation in outcome.violations)
        error = EVIL if flown.mutant else ""
        return replace(outcome, subject=flown.subject, violations=struck, struck=MARKED, stack_error=error)


def _hostile(value: Any) -> Any:
    """The document with every free text made hostile."""
    if isinstance(value, dict):
        return {key: _evil(entry) if key in FREE else _hostile(entry) for key, entry in value.items()}
    return [_hostile(entry) for entry in value] if isinstance(value, list) else value


def _evil(value: Any) -> Any:
    if isinstance(value, list):
        return [_evil(entry) for entry in value]
    return f"{EVIL} {value}" if isinstance(value, str) else _hostile(value)


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> Call:
    """Call a verb on a hostile study with a hostile campaign of a hostile name."""
    folder = copied(tmp_path_factory.mktemp("texts") / "=study \x1b[1m\u202e")
    sim = [folder / "sim" / f"{name}.yaml" for name in ("situations", "requirements")]
    for path in (*folder.glob("hazop/**/*.yaml"), *sim):
        text = path.read_text(encoding="utf-8")
        keys = yaml.load(text, yaml.BaseLoader)  # YAML would read the guideword NO as false
        keyed = dict(zip(keys, yaml.safe_load(text).values(), strict=True))
        path.write_text(yaml.safe_dump(_hostile(keyed), sort_keys=False), encoding="utf-8")
    accepted = {"status": "accepted", "owner": EVIL, "reason": EVIL, "expires": "2999-01-01"}
    (folder / "hazop" / "dispositions.yaml").write_text(yaml.safe_dump({"NO-human@100%": accepted}))
    campaign = ["--study", str(folder), "--campaign", f"{folder.parent}/=c \x1b[1m\u202e"]

    def telling(verb: str, *words: str) -> Result:
        plain = ("mutants", "diff", "signals", "seams", "operators", "axes")
        named = campaign if verb not in plain else campaign[:2]
        twice = [campaign[3]] * 2 if verb == "diff" else []
        return invoked(verb, *twice, *words, *named)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("scaloft_fi.campaign.flights.physics.Physics", Evil)
        flights = ("--mutant", "LATE-human", "--mutant", "NO-human", "--situation", "T0O0W0D0H1", "--seeds", "3")
        flown = telling("run", *flights, "--jobs", "1", "--warnings")
    assert flown.exit_code == 0, flown.output
    assert obeyed(flown.output) == set()
    return telling


def _cells(text: str) -> list[str]:
    return [cell for row in csv.reader(io.StringIO(text, newline="")) for cell in row]


def _is_formula(cell: str) -> bool:
    return cell.startswith(("=", "+", "-", "@", "\t", "\r")) and not re.fullmatch(r"-|[-+]?[\d.]+(e[-+]?\d+)?", cell)


@pytest.mark.parametrize("style", usually(["table"], release=FORMATS))
def test_no_table_of_any_verb_is_obeyed(told: Call, style: str):
    for verb in VERBS:
        done = told(*verb, "--format", style)
        assert done.exit_code == 0, (verb, done.output)
        assert obeyed(done.output) == set(), verb
        if style == "csv":
            assert [cell for cell in _cells(done.stdout) if _is_formula(cell)] == [], verb
        if style == "json":
            json.loads(done.stdout)
        if style == "markdown":
            assert not re.search(r"(?<!\\)<b>|(?<!\\)\[l\]", done.stdout), verb
            rows = [line for line in done.stdout.splitlines() if line.startswith("|")]
            assert all(re.search(r"(?<!\\)\|$", row) for row in rows), verb
        if style == "latex":
            assert "\\input" not in done.stdout, verb


def test_what_is_hostile_is_shown(told: Call):
    assert "=1+1|<b>x</b>\\x1b[31m\\x9b\\x7f\\u202e\\u200b\\x07" in told("worksheet", "--format", "csv").stdout
    assert json.loads(told("worksheet", "--format", "json").stdout)["rows"][0]["deviation"].startswith(EVIL)
    assert "Campaign " in told("status").stdout
    assert "=c \\x1b[1m\\u202e" in " ".join(told("status").stdout.split())


@pytest.mark.parametrize("style", EXPORTS)
def test_no_export_is_obeyed(told: Call, tmp_path: Path, style: str):
    path = tmp_path / "out"
    assert told("export", "--format", style, "--output", str(path)).exit_code == 0
    text = path.read_text(encoding="utf-8")
    assert obeyed(text) == set()
    assert told("export", "--format", style).stdout == text
    if "json" in style or style in ("sarif", "mutation-testing"):
        json.loads(text)
    if style == "junit":
        ElementTree.fromstring(text)
    if style == "gsn":
        yaml.safe_load(text)


def test_rows_of_csv_are_read_back(told: Call):
    text = told("export", "--format", "csv").stdout
    assert [cell for cell in _cells(text) if _is_formula(cell)] == []
    rows = list(csv.DictReader(io.StringIO(text, newline="")))
    whole = json.loads(told("export", "--format", "json").stdout)
    back = [re.sub(r"^'(?='*[=+@-])", "", row["struck"]) for row in rows]
    assert any(back)
    assert back == [printable(row["struck"]) for row in whole]


def test_pages_and_pictures_are_not_obeyed(told: Call, tmp_path: Path):
    for verb, name in (("report", "page.html"), ("kills", "graph.svg"), ("kills", "graph.dot")):
        done = told(verb, "--output", str(tmp_path / name))
        assert done.exit_code == 0, done.output
        text = (tmp_path / name).read_text(encoding="utf-8")
        assert obeyed(text + done.output) == set(), name
        assert "<b>" not in text, name


def test_no_error_sentence_is_obeyed(told: Call):
    wrong = (("kills", "\x1b[2J\u202e"), ("matrix", "--cell", "\x1b"), ("export", "--format", "\x9b\n"), ("\x1b[2J",))
    for words in wrong:
        done = told(*words)
        assert done.exit_code == 2
        assert obeyed(done.output) == set()
        assert done.stderr.count("\n") == 1
