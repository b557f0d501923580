from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path

from click.testing import Result
from refusal import sentence

Call = Callable[..., Result]


def test_an_export_has_one_row_per_flight_in_order_and_csv_says_the_same(call: Call) -> None:
    call("run", "--mutant", "LATE-human", "--situation", "T0O0W0D0H?", "--quiet")
    rows = json.loads(call("export").stdout)
    assert [(row["mutant"], row["situation"]) for row in rows] == [
        (mutant, f"T0O0W0D0H{h}") for mutant in ("baseline", "PLACEBO", "LATE-human@3s") for h in (0, 1)
    ] + [("REVERSE-velcmd", "T0O0W0D0H0")]
    assert rows[-2]["violated"] == ["SR2"]
    table = list(csv.DictReader(io.StringIO(call("export", "--format", "csv").stdout)))
    assert [row["digest"] for row in table] == [row["digest"] for row in rows]


def test_an_export_can_go_to_a_file(call: Call, tmp_path: Path) -> None:
    call("run", "--mutant", "PLACEBO", "--situation", "T0O0W0D0H0", "--quiet")
    assert call("export", "--output", str(tmp_path / "e.json")).stdout == ""
    assert json.loads((tmp_path / "e.json").read_text())[0]["mutant"] == "baseline"
    assert "cannot be written" in sentence(call("export", "--output", str(tmp_path / "no" / "e.json")))


def test_nothing_is_exported_of_a_campaign_that_was_never_flown(call: Call, tmp_path: Path) -> None:
    assert "no campaign was flown here" in sentence(call("export"))
    assert list(tmp_path.iterdir()) == []
