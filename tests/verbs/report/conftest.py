"""A campaign on paper, one with hostile names."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml
from pages import Opened, Visit, embedded
from papers import HOSTILE, STUDY, campaign, evidence_of
from studies import copied

from scaloft_fi.document import load
from scaloft_fi.study import NO_FINDS, Study
from scaloft_fi.verbs.report.analyses import Evidence
from scaloft_fi.verbs.report.page import figures, page


@pytest.fixture(scope="session")
def study() -> Study:
    """The reference study without its finds."""
    opened = Study.open(STUDY)
    vars(opened)["finds"] = NO_FINDS
    return opened


@pytest.fixture(scope="session")
def evidence(study: Study) -> Evidence:
    """Three seeds beside a pool of ten, one flight that failed."""
    outcomes = list(campaign(study))
    broken = next(i for i, o in enumerate(outcomes) if o.mutant == "LESS-goal@0.05m")
    outcomes[broken] = replace(
        outcomes[broken], invalid="the worker died", readings=(), violations=(), track=b"", digest="", ending=""
    )
    return evidence_of(study, outcomes)


@pytest.fixture(scope="session")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> Evidence:
    """A study whose titles, reasons and names try to be markup, in a folder with such a name."""
    folder = tmp_path_factory.mktemp("hostile") / "st\"u'dy <b onclick=alert(1)>&amp;"
    copied(folder, "found.yaml")

    def change(path: Path, edit: Callable[[dict[str, Any]], None]) -> None:
        document = load(path).plain()
        edit(document)
        path.write_text(yaml.safe_dump(document, allow_unicode=True, sort_keys=False), encoding="utf-8")

    def titles(document: dict[str, Any]) -> None:
        for number, entry in enumerate(document.values()):
            entry["title"] = HOSTILE[number % len(HOSTILE)]
            entry["intent" if "intent" in entry else "meaning"] = HOSTILE[(number + 1) % len(HOSTILE)]

    def axes(document: dict[str, Any]) -> None:
        for number, axis in enumerate(document["axes"].values()):
            axis["title"] = HOSTILE[number]
            for place, value in enumerate(axis["values"]):
                value["title"] = HOSTILE[(number + place + 1) % len(HOSTILE)]

    def requirements(document: dict[str, Any]) -> None:
        for number, requirement in enumerate(document["requirements"].values()):
            requirement["title"] = requirement["unit"] = HOSTILE[number]
            # a quotient has no unit that `unit` would have to be
            requirement["formula"] = requirement["formula"].replace("clearance_m > 0", "clearance_m / 1 > 0")

    change(folder / "hazop" / "parameters.yaml", titles)
    change(folder / "hazop" / "guidewords.yaml", titles)
    change(folder / "sim" / "situations.yaml", axes)
    change(folder / "sim" / "requirements.yaml", requirements)
    accepted = {"status": "accepted", "owner": HOSTILE[0], "reason": HOSTILE[1], "expires": "2027-01-31"}
    text = yaml.safe_dump({"LATE-human": accepted}, allow_unicode=True)
    (folder / "hazop" / "dispositions.yaml").write_text(text, encoding="utf-8")
    study = Study.open(folder)
    outcomes = list(campaign(study, ("LATE-human@3s", "MORE-goal@0.6m", "REVERSE-velcmd"), range(1)))
    outcomes = [replace(o, stack_error=HOSTILE[0]) if o.mutant.startswith("LATE") else o for o in outcomes]
    return Evidence(study, HOSTILE[0], tuple(outcomes), fingerprint={HOSTILE[1]: HOSTILE[2]})


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> Callable[[Evidence], dict[str, Any]]:
    """The figures without what follows from the flights, which takes longest."""
    monkeypatch.setattr("scaloft_fi.verbs.report.analyses.analyses", lambda *_: {})
    return figures


@pytest.fixture(scope="session")
def text(evidence: Evidence) -> str:
    """The page of the campaign on paper."""
    return page(evidence)


@pytest.fixture(scope="session")
def told(text: str) -> dict[str, Any]:
    """The figures of that page."""
    return embedded(text, "figures")


@pytest.fixture(scope="session")
def hostile_text(hostile: Evidence) -> str:
    """The page of the hostile study."""
    return page(hostile)


@pytest.fixture(scope="session")
def path(text: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    written = tmp_path_factory.mktemp("page") / "report.html"
    written.write_text(text, encoding="utf-8")
    return written


@pytest.fixture
def visit(browser: Any, path: Path) -> Iterator[Opened]:
    visits: list[Visit] = []

    def opened(fragment: str = "", file: Path = path, **context: Any) -> Visit:
        visits.append(Visit(browser, file, fragment, **context))
        return visits[-1]

    yield opened
    for one in visits:
        one.close()
