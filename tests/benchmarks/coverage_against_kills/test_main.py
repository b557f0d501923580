from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest
from builders import outcome, pool

from experiments.coverage_against_kills import __main__ as experiment
from scaloft_fi.analysis.detection import Spending
from scaloft_fi.errors import InputError
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import rulings_of
from scaloft_fi.study import Study

ROOT = Path(__file__).parents[3]
KEYS = ("T0O0W0D0H0", "T0O0W0D0H1")


def holding(monkeypatch: pytest.MonkeyPatch, outcomes: Sequence[Outcome]) -> None:
    @contextmanager
    def snapshot(study: Study, campaign: str) -> Iterator[SimpleNamespace]:
        yield SimpleNamespace(rulings=rulings_of(outcomes), spending=Spending())

    monkeypatch.setattr(experiment, "snapshot", snapshot)


def test_it_writes_the_tables_and_the_picture(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    holding(monkeypatch, [*pool(*KEYS), *(outcome("LATE-human@3s", key, violated={"SR2": 8.0}) for key in KEYS)])
    experiment.main(["--output", str(tmp_path)])
    text = (tmp_path / "coverage_against_kills.md").read_text(encoding="utf-8")
    assert "Does coverage predict kills beyond the number of situations?" in text or "Nothing follows" in text
    assert (tmp_path / "coverage_against_kills.svg").read_text(encoding="utf-8").startswith("<svg")


def test_a_campaign_without_default_mutants_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    holding(monkeypatch, [*pool(*KEYS), outcome("LATE-human@1s", KEYS[0])])
    with pytest.raises(InputError, match="needs default mutants of credible cells: none was flown"):
        experiment.pages(Study.open(ROOT), "any")
