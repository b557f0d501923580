from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from forms import one_table
from refusal import sentence

Call = Callable[..., Result]
LATE = "LATE-human@3s"


@pytest.fixture
def flown(call: Call) -> Call:
    """A campaign of LATE-human, which the paper flyer lets violate SR2 where a person is, and of a survivor."""
    words = ("--mutant", "LATE-human", "--mutant", "EARLY-human", "--situation", "T0O?W0D0H?", "--seeds", "3")
    assert call("run", *words, "--quiet").exit_code == 0
    return call


def test_it_tells_where_a_mutant_is_killed_and_what_situations_keep_every_kill(flown: Call) -> None:
    result = flown("kills")
    assert result.exit_code == 0
    text = " ".join(result.stdout.split())
    assert f"{LATE} 2 1-4 human" in text
    assert "Fewest situations that keep every kill: 1, proved; sets of that size: 2." in text
    assert "EARLY-human@3s" in text.partition("Survivors")[2]


def test_a_part_is_shown_at_length(flown: Call) -> None:
    result = flown("kills", "--show", "survivors", "--format", "markdown")
    assert "| EARLY-human@3s | delay | not tested | infect | situation |" in " ".join(result.stdout.split())
    assert "Killed where" not in result.stdout


def test_every_part_is_a_csv_file_of_its_own(flown: Call, tmp_path: Path) -> None:
    done = flown("kills", "--show", "survivors", "--format", "csv", "--tables", str(tmp_path / "tables"))
    rows = one_table((tmp_path / "tables" / "survivors.csv").read_text())
    assert [(row["mutant"], row["stage"], row["next"]) for row in rows] == [("EARLY-human@3s", "infect", "situation")]
    assert one_table(done.stdout) == rows
    for part in ("conditions", "situations", "suite", "subsumption"):
        assert one_table(flown("kills", "--show", part, "--format", "csv").stdout)
    assert {row["id"] for row in one_table(flown("kills", "--format", "csv").stdout)} >= {LATE, "EARLY-human@3s"}


def test_json_has_the_matrix_and_every_part(flown: Call) -> None:
    plain = json.loads(flown("kills", "--format", "json").stdout)
    parts = {"conditions", "orders", "situations", "suite", "subsumption", "redundancies", "survivors"}
    assert {name for name, value in plain.items() if value is None} == {"chosen"}
    assert parts < set(plain)
    assert [entry["verdict"] for entry in plain["survivors"]] == ["not_tested"]
    assert plain["conditions"][0]["condition"] == "human"
    assert plain["suite"]["alternatives"] == 2
    some = json.loads(flown("kills", "LATE-human", "--show", "suite", "--format", "json").stdout)
    assert {name for name in parts if some[name] is not None} == {"suite"}
    assert [row["id"] for row in some["mutants"]] == [LATE]


def test_what_one_seed_shows_is_undecided_and_says_how_many_seeds_decide(call: Call) -> None:
    words = ("--mutant", "LATE-human", "--situation", "T0O?W0D0H?", "--quiet")
    assert call("run", *words).exit_code == 0
    text = " ".join(call("kills", "--show", "survivors").stdout.split())
    assert "2 of 2 flights where SR2 is steady violate it" in text
    assert re.search(rf"`scaloft-fi run --campaign .+ --mutant {LATE} --seeds 3`", text)
    assert json.loads(call("kills", "--format", "json").stdout)["conditions"] == []


def test_seeds_that_were_asked_for_later_spend_alpha_by_looks(call: Call) -> None:
    """Two situations of three seeds: detected at a quarter of alpha too; of one alone they are not."""
    words = ("--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    for seeds in ("1", "3"):
        assert call("run", *words, "--seeds", seeds).exit_code == 0
    (survivor,) = json.loads(call("kills", "--show", "survivors", "--format", "json").stdout)["survivors"]
    assert (survivor["verdict"], "alpha 0.0025" in survivor["why"]) == ("undecided", True)


def test_what_some_situations_kill_is_told(flown: Call) -> None:
    lone = json.loads(flown("kills", "--situation", "T0O0W0D0H0", "--show", "suite", "--format", "json").stdout)
    assert lone["chosen"]["lost"] == [LATE]
    assert "dominator score 1/1 = 100 %" in " ".join(flown("kills", "--situation", "T0O?W0D0H1").stdout.split())
    assert "situation" in sentence(flown("kills", "--situation", "T0O0W0D0H7"))


def test_kills_by_requirement_are_told_apart(flown: Call) -> None:
    plain = json.loads(flown("kills", "--by-requirement", "--show", "subsumption", "--format", "json").stdout)
    assert all(key.endswith(" SR2") for key in plain["subsumption"]["nodes"][0]["kills"])


@pytest.mark.parametrize("suffix", [".svg", ".png", ".dot"])
def test_all_are_drawn_as_the_subsumption_graph(flown: Call, tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"graph{suffix}"
    assert flown("kills", "--output", str(path)).exit_code == 0
    assert path.stat().st_size > 100


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--output", "map.pdf"), "must end in .svg, .png or .dot"),
        (("LATE-humn",), "did you mean"),
        (("NO-goal",), "holds no flight of NO-goal"),
    ],
)
def test_what_cannot_be_is_refused_in_asentence(flown: Call, words: tuple[str, ...], said: str) -> None:
    assert said in sentence(flown("kills", *words))


def test_without_a_campaign_it_says_so(call: Call) -> None:
    assert "no campaign was flown here" in sentence(call("kills"))
