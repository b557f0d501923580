"""`run --shard`, `merge` and `diff`, without physics."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

Call = Callable[..., Result]

WORDS = ("--mutant", "LATE-human", "--situation", "T0O0W0D?H?", "--quiet")


def _shards(call: Call, folder: Path) -> list[str]:
    names = [f"{folder}/{k}" for k in (1, 2)]
    for k, name in enumerate(names, 1):
        result = call("run", *WORDS, "--shard", f"{k}/2", "--campaign", name, campaign=False)
        assert result.exit_code == 0, result.output
    return names


def test_two_shards_merged_export_the_bytes_of_the_undivided_run(call: Call, tmp_path: Path) -> None:
    call("run", *WORDS)
    names = _shards(call, tmp_path)
    merged = call("merge", *names, "--campaign", f"{tmp_path}/both", campaign=False)
    assert merged.stdout == f"31 flights added to {tmp_path}/both, 0 known already\n"
    both = call("export", "--campaign", f"{tmp_path}/both", campaign=False)
    assert both.stdout == call("export").stdout


def test_diff_prints_what_only_one_of_two_campaigns_has(call: Call, tmp_path: Path) -> None:
    first, second = _shards(call, tmp_path)
    result = call("diff", first, second, campaign=False)
    assert result.exit_code == 0
    assert "0 flights are the same bit for bit" in result.stdout.replace("\n", " ")
    assert "0 differ" in call("diff", first, first, campaign=False).stdout.replace("\n", " ")


@pytest.mark.parametrize("text", ["0/2", "3/2", "1", "a/b", "1/0"])
def test_a_shard_that_is_none_is_refused(call: Call, text: str) -> None:
    result = call("run", *WORDS, "--shard", text)
    assert result.exit_code == 2
    assert f"--shard={text!r} must be K/N" in result.stderr


def test_a_shard_without_flights_is_refused(call: Call) -> None:
    result = call("run", *WORDS, "--shard", "9/9")
    assert result.exit_code == 2
    assert "fewer situations and seeds than shards" in result.stderr


def test_status_counts_what_is_planned(call: Call) -> None:
    call("run", *WORDS)
    line = next(line for line in call("status").stdout.splitlines() if line.startswith("planned, not flown"))
    assert line.split()[-1] == "0"
