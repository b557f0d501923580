"""`report`: the page of a campaign, where it is asked for."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

from click.testing import Result

Call = Callable[..., Result]


def _figures(path: Path) -> dict[str, object]:
    found = re.search(r'id="figures">(.*?)</script>', path.read_text(encoding="utf-8"), re.DOTALL)
    assert found
    told: dict[str, object] = json.loads(found[1])
    return told


def test_the_page_of_a_campaign_is_written_into_its_folder_and_says_what_score_says(call: Call, tmp_path: Path) -> None:
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    result = call("report")
    assert result.exit_code == 0, result.output
    path = tmp_path / "campaign" / "report.html"
    assert result.stdout == f"report: {path} ({len(path.read_bytes()) / 1e6:.1f} MB)\n"
    told = _figures(path)
    scored = json.loads(call("score", "--format", "json").stdout)
    ratios = {ratio["name"]: ratio for ratio in told["ratios"]}  # type: ignore[attr-defined]
    assert scored["ratios"].pop("without_accepted") == scored["ratios"]["mutation_score"]  # nobody accepted any
    for name, ratio in scored["ratios"].items():
        assert (ratios[name]["part"], ratios[name]["whole"]) == (ratio["part"], ratio["whole"])
    assert told["pairs"] == scored["pairs"]
    assert told["coverage"] == scored["coverage"]
    rows = json.loads(call("export").stdout)
    assert told["flights"] == len(rows)


def test_the_page_can_go_elsewhere_and_the_same_campaign_makes_the_same_bytes(call: Call, tmp_path: Path) -> None:
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet")
    pages = [tmp_path / "a.html", tmp_path / "b.html"]
    for path in pages:
        assert call("report", "--output", str(path)).exit_code == 0
    assert pages[0].read_bytes() == pages[1].read_bytes()


def test_a_day_is_taken_from_the_command_line_only(call: Call, tmp_path: Path) -> None:
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H1", "--quiet")
    path = tmp_path / "a.html"
    for words, today in (((), None), (("--today", "2027-02-01"), "2027-02-01")):
        assert call("report", "--output", str(path), *words).exit_code == 0
        assert _figures(path)["accepted"]["today"] == today  # type: ignore[index]
