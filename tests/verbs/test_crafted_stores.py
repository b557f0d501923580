"""Every verb that reads a campaign, on stores that somebody crafted: one sentence or a result, and no trace."""

from __future__ import annotations

import shutil
from functools import cache
from itertools import count
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from crafted import ONE, Crafted, campaign, crafted, sql
from printed import STUDY, Call, sentence

from scaloft_fi.campaign.store.record import MOST_FLIGHTS
from scaloft_fi.cli import main
from scaloft_fi.study import Study

NAME = "outcomes.sqlite"
FIXED = (("status",), ("report", "--output", "OUT"))
"""These read every table."""
OTHERS = (
    ("score", "--all"),
    ("score", "--format", "json"),
    ("kills",),
    ("kills", "--format", "json", "--show", "survivors"),
    ("coverage",),
    ("compare", "CRAFTED", "GOOD"),
    ("compare", "GOOD", "CRAFTED", "--flights"),
    ("export",),
    ("export", "--format", "junit"),
    ("export", "--format", "parquet", "--output", "OUT"),
    ("worksheet", "--format", "csv"),
    ("dispositions",),
    ("matrix", "--margins"),
    ("score", "--baseline-from", "CRAFTED"),
)
turn = count()


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("good")
    campaign(Study.open(STUDY), folder / NAME)
    return folder


@pytest.fixture
def read(good: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Call:
    """Call a verb on the campaign in the folder `crafted`; the study is read once."""
    study = _study()
    monkeypatch.setattr(Study, "open", lambda _folder=None: study)
    (tmp_path / "crafted").mkdir()
    shutil.copy(good / NAME, tmp_path / "crafted" / NAME)
    names = {"CRAFTED": f"{tmp_path}/crafted", "GOOD": str(good), "OUT": f"{tmp_path}/out"}

    def calling(*words: str) -> Result:
        told = [names.get(word, word) for word in words]
        where = () if words[0] == "compare" else ("--campaign", f"{tmp_path}/crafted")
        return CliRunner().invoke(main, [*told, "--study", str(STUDY), *where])

    return calling


@cache
def _study() -> Study:
    return Study.open(STUDY)


def _content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def _ends_well(result: Result, path: Path) -> bool:
    """Whether the verb has read the store; otherwise it has refused it with one sentence that names the file."""
    if result.exit_code == 0:
        return True
    assert result.exit_code == 2, result.output
    (line,) = result.stderr.strip().splitlines()
    assert line.startswith("error: ")
    return str(path) not in line  # a sentence about the campaign, such as that it has no pool


@pytest.mark.parametrize("store", [*crafted()], ids=lambda store: store.name)
def test_a_crafted_store_is_read_or_refused_with_a_sentence_and_left_alone(read: Call, tmp_path: Path, store: Crafted):
    path = tmp_path / "crafted" / NAME
    store.make(path)
    before = _content(path.parent)
    for words in (FIXED[next(turn) % 2], OTHERS[next(turn) % len(OTHERS)]):
        _ends_well(read(*words), path)
    if store.says:
        result = read(*store.by)
        assert result.exit_code == 2, result.output
        assert all(part in result.stderr for part in (str(path), *store.says.split("|"))), result.stderr
        assert len(result.stderr) < 500
    assert _content(path.parent) == before


@pytest.mark.parametrize("words", [*FIXED, *OTHERS], ids=" ".join)
def test_a_verb_that_reads_changes_nothing_and_creates_nothing(read: Call, tmp_path: Path, words: tuple[str, ...]):
    folder = tmp_path / "crafted"
    before = _content(folder)
    assert read(*words).exit_code == 0
    assert _content(folder) == before
    (folder / NAME).write_bytes(b"")
    assert read(*words).exit_code == 2
    assert _content(folder) == {NAME: b""}
    shutil.rmtree(folder)
    assert "no campaign was flown here" in sentence(read(*words))
    assert not folder.exists()
    assert {path.name for path in tmp_path.iterdir()} <= {"out"}


def test_a_table_with_too_many_rows_is_refused_and_the_limit_can_be_raised(
    read: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv(MOST_FLIGHTS, "30")
    twelve = "WITH RECURSIVE r (n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM r LIMIT 12)"
    columns = "key || n, mutant, situation, seed, canary, origin"
    assert read("status").exit_code == 0
    sql(f"{twelve} INSERT INTO plan SELECT {columns} FROM plan, r {ONE}")(tmp_path / "crafted" / NAME)
    result = read("status")
    assert result.exit_code == 2
    assert (
        f"table plan has more rows than the limit for 30 flights; the environment variable {MOST_FLIGHTS}"
        in result.stderr
    )
    assert read("score").exit_code == 0
    for most, code in (("10", 2), ("31", 0), ("0", 2), ("many", 2)):
        monkeypatch.setenv(MOST_FLIGHTS, most)
        assert read("status").exit_code == code
