from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from forms import of_form

from scaloft_fi.campaign.runs.gates import published
from scaloft_fi.campaign.store.platforms import fingerprint
from scaloft_fi.errors import GateError

Call = Callable[..., Result]


@pytest.fixture
def answer(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[[], str]], None]:
    """Replaces the known flight."""

    def become(tell: Callable[[], str]) -> None:
        monkeypatch.setattr("scaloft_fi.verbs.doctor.fly_again", lambda _say: tell())

    become(lambda: "as published")
    return become


def _told(result: Result) -> dict[str, Any]:
    return of_form("doctor", result.stdout)


def test_every_part_of_the_platform_is_told_with_whether_it_decides_bits(call: Call, answer: object) -> None:
    result = call("doctor", "--format", "json", campaign=False)
    assert result.exit_code == 0, result.output
    whole = _told(result)
    told = {row["part"]: (row["value"], row["decides_bits"]) for row in whole["platform"]}
    assert {name: value for name, (value, _) in told.items()}.items() >= fingerprint().items()
    assert {told[name][1] for name in ("numpy kernels", "OPENBLAS_CORETYPE")} == {True}
    assert told["scaloft-fi"][1] is False
    packages = {row["package"]: row for row in whole["packages"]}
    assert packages["numpy"]["version"] == fingerprint()["numpy"]
    assert packages["distributed"]["extra"] == "cluster"
    assert "pytest" not in packages
    assert (whole["study"]["mutants"], whole["study"]["situations"]) == (712, 32)
    assert 0 < whole["machine"]["memory_available_gib"] < whole["machine"]["memory_gib"]
    assert whole["known_flight"] == {"same": True, "told": "as published"}
    text = " ".join(call("doctor", campaign=False).stdout.split())
    for words in ("current, 712 mutants", "GiB available of", "be written", "as published"):
        assert words in text


def test_without_the_flight_nothing_is_flown(call: Call, answer: Callable[[Callable[[], str]], None]) -> None:
    answer(lambda: pytest.fail("it flew"))
    result = call("doctor", "--no-flight", campaign=False)
    assert result.exit_code == 0
    assert "Known flight" not in result.stdout


def test_other_facts_of_the_known_flight_exit_with_4_after_the_tables(
    call: Call, answer: Callable[[Callable[[], str]], None]
) -> None:
    def fail() -> str:
        raise GateError(f"{published().name} has other facts")

    answer(fail)
    result = call("doctor", campaign=False)
    assert result.exit_code == 4
    assert "Platform" in result.stdout
    assert result.stdout.count("has other facts") == 1
    assert result.stderr == f"error: {published().name} has other facts\n"


def test_a_plugin_that_does_not_load_is_named_and_everything_else_is_told(
    call: Call, answer: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    plugins = [EntryPoint("odd", "no_such_module_at_all", "g"), EntryPoint("well", "json", "g")]
    monkeypatch.setattr("scaloft_fi.verbs.doctor.entry_points", lambda **_: plugins)
    result = call("doctor", "--format", "json", campaign=False)
    assert result.exit_code == 2
    assert "plugin 'odd' of package 'no_such_module_at_all' cannot be loaded: ModuleNotFoundError" in result.stderr
    assert [(row["plugin"], row["loads"]) for row in _told(result)["plugins"]] == [("odd", False), ("well", True)]


def test_a_stale_catalogue_is_bad_input_and_everything_else_is_told(call: Call, answer: object, copy: Path) -> None:
    catalogue = copy / "mutants" / "catalogue.jsonl"
    catalogue.write_text("".join(catalogue.read_text().splitlines(keepends=True)[1:]))
    result = call("doctor", "--format", "json", study=copy, campaign=False)
    assert result.exit_code == 2
    assert "mutants --write" in result.stderr
    assert _told(result)["known_flight"]
