"""Pages of the site that hold what is measured or declared: API, requirements, README's example."""

from __future__ import annotations

import doctest
import re
import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path

import pytest
from published_flights import ROOT, outcomes

import scaloft_fi
from scaloft_fi.analysis.coverage import coverage
from scaloft_fi.analysis.score import score
from scaloft_fi.cli import command_of, main
from scaloft_fi.errors import ScaloftError
from scaloft_fi.judge.outcome import BASELINE, Outcome
from scaloft_fi.judge.requirement import Compliance, Requirement, judge_signals, load_requirements, within_caps
from scaloft_fi.judge.stl import Formula
from scaloft_fi.study import Study
from scaloft_fi.verbs import VERBS
from scaloft_fi.verbs.first_screen import Screen

PAGE = ROOT / "docs" / "api.md"


@pytest.mark.flight
@pytest.mark.release
def test_every_example_of_the_page_gives_what_the_page_shows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    text = re.sub(r"^```.*$", "", PAGE.read_text(), flags=re.MULTILINE)  # else the end of a block is expected output
    page = doctest.DocTestParser().get_doctest(text, {}, "docs/api.md", str(PAGE), 0)
    said: list[str] = []
    failed, tried = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(page, out=said.append)
    assert tried > 20
    assert not failed, "".join(said)
    assert [one.name for one in tmp_path.iterdir()] == ["notebook"], "an example wrote elsewhere"


def test_the_page_lists_every_error():
    errors = [name for name in scaloft_fi.__all__ if name != "ScaloftError" and _is_error(getattr(scaloft_fi, name))]
    assert all(f"| `{name}` |" in PAGE.read_text() for name in errors)


def test_the_page_lists_every_type_of_column():
    table = PAGE.read_text().partition("| column | holds |")[2].partition("\n\n")[0]
    assert set(re.findall(r"`(\w+)`", "\n".join(row.split("|")[1] for row in table.splitlines()[2:]))) == {
        kind.value for kind in scaloft_fi.ColumnType
    }


def _is_error(value: object) -> bool:
    return isinstance(value, type) and issubclass(value, ScaloftError)


def _paragraphs(page: str) -> list[str]:
    """The paragraphs of a page; blocks, tables, pictures and headings are none."""
    parts = re.sub(r"^```.*?^```", "", page, flags=re.MULTILINE | re.DOTALL).split("\n\n")
    return [part for part in parts if part.strip() and not part.strip().startswith(("#", "<", "|", "!", "---"))]


def _help(name: str) -> str:
    """What `--help` says of a verb and its options, each a paragraph; its examples are left out."""
    command = command_of(name)
    options = [getattr(option, "help", None) or "" for option in command.params]
    return "\n\n".join([str(command.help).partition("Examples:")[0], *options])


FIRST_SCREENS = {
    **{
        str(path.relative_to(ROOT)): "\n\n".join(_paragraphs(path.read_text())[:2])
        for path in (*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("examples/*/README.md"))
        if path.name != "CHANGELOG.md"
    },
    **{f"{name} --help": _help(name) for name in VERBS},
}
"""What a reader sees first of each page and of each verb."""


def test_no_sentence_of_a_first_screen_has_more_than_25_words():
    assert len(FIRST_SCREENS) > 60
    sentences = [
        (place, sentence)
        for place, text in FIRST_SCREENS.items()
        for sentence in re.split(r"[.:?!]\W*\s|\n\n|\n *- ", re.sub(r"`[^`]*`", "X", text))
    ]
    assert [one for one in sentences if len(one[1].split()) > 25] == []


MUTANT, CONTROL = "LATE-human@3s", ("REVERSE-velcmd", "T0O0W0D0H0")


def _flown() -> list[Outcome]:
    """What `run --mutant LATE-human` flies: one seed, ten of the baseline where the mutant infects, one control."""
    published = outcomes()
    mutant = [one for one in published if one.mutant == MUTANT and one.seed == 0]
    infected = {one.situation for one in mutant if one.altered}
    seeds = {key: range(10) if key in infected else range(1) for key in {one.situation for one in mutant}}
    return [
        *(one for one in published if one.mutant == BASELINE and one.seed in seeds[one.situation]),
        *mutant,
        *(one for one in published if (one.mutant, one.situation) == CONTROL and one.seed == 0),
    ]


def test_the_screen_is_that_of_the_published_flights():
    study, flown = Study.open(ROOT), _flown()
    scored = score(flown, study.roster, study.space)
    screen = Screen(study, scored, coverage(flown, study.space))
    shown = re.search(r"^```\n(Shown .*?)^```$", (Path(ROOT) / "README.md").read_text(), re.MULTILINE | re.DOTALL)
    assert shown
    assert shown[1] == screen.text(whole=False)


def test_readme_has_at_most_120_lines():
    assert len((ROOT / "README.md").read_text().splitlines()) <= 120


MOST_WORDS = 25
"""Of a sentence that a newcomer reads first."""


SCORE = ROOT / "results" / "published" / "reference" / "score.md"
FIRST = {
    "README": (ROOT / "README.md").read_text().partition("<!-- run -->")[0],
    "index.md": (ROOT / "docs" / "index.md").read_text(),
    "--help": str(main.help),
    "first screen": "\n\n".join(
        re.findall(r"^\| (?:Shown|Not shown|How sure|What next) +\| (.*?) +\|$", SCORE.read_text(), re.MULTILINE)
    ),
}


@pytest.mark.parametrize("name", FIRST)
def test_no_sentence_that_a_newcomer_reads_first_is_long(name: str):
    text = re.sub(r"^```.*?^```$|^[|#!].*?$", "\n", FIRST[name], flags=re.M | re.S)
    assert text.strip()
    sentences = [one for part in text.split("\n\n") for one in re.split(r"(?<=[.?!])[*)]*\s+", part)]
    assert [one for one in sentences if len(re.findall(r"\w\S*", one)) > MOST_WORDS] == []


SHIPPED = {"hazop", "mutants", "sim", "scaloft_fi"}
"""The folders of the repository that an installed wheel has too, with the same names of files."""
OWN = {path.name for path in ROOT.glob("[!.]*/") if path.name not in SHIPPED}
PATH = re.compile(r"(?<![\w./-])([\w.-]+)(?:/[\w.*-]+)+")


@pytest.mark.parametrize("page", sorted((ROOT / "docs").glob("*.md")), ids=lambda path: path.stem)
def test_no_page_names_a_file_that_a_wheel_lacks(page: Path):
    """Only what the repository has is looked for: a study and a package of a user's own have folders `tests/` too."""
    text = page.read_text()
    named = [found[0].rstrip(".") for found in PATH.finditer(text) if found[1] in OWN]
    assert [path for path in named if any(ROOT.glob(path)) and not path.startswith("results/campaigns")] == []
    assert re.findall(r"\b(?:CONTRIBUTING|DESIGN|CHANGELOG)\.md|CITATION\.cff", text) == []


HOOKS = ROOT / "docs" / "hooks"


@pytest.mark.parametrize("name", sorted(path.stem for path in HOOKS.glob("*.py")))
def test_its_examples_hold(name: str, monkeypatch: pytest.MonkeyPatch):
    pytest.importorskip("mkdocs")
    monkeypatch.syspath_prepend(str(HOOKS))
    assert doctest.testmod(import_module(name)).failed == 0
    assert Path(str(sys.modules[name].__file__)).parent == HOOKS


REQUIREMENTS = ROOT / "docs" / "requirements.md"
SAMPLES = 160
"""Eight seconds."""
Track = Callable[[float], float]
Told = Mapping[str, float | Track]
BENIGN: Told = {
    "elapsed_s": lambda t_s: t_s,
    "remaining_s": lambda t_s: 8.0 - t_s,
    "z_m": 1.65,
    "speed_mps": 0.4,
    "light": 1.0,
    **dict.fromkeys(("clearance_m", "clearance_wall_m", "clearance_person_m"), 1.0),
    **dict.fromkeys(("person_sight_m", "person_range_m", "waypoint_wall_m"), 100.0),
}


def _until(end_s: float, before: float, after: float) -> Track:
    return lambda t_s: before if t_s < end_s else after


FLIGHTS: Mapping[str, tuple[Told, Told]] = {
    "CLEAR": ({"clearance_m": 0.05}, {"clearance_m": 0.2}),
    "PERSON": ({"clearance_person_m": 0.4}, {"clearance_person_m": 0.6}),
    "SPEED": ({"speed_mps": 1.3}, {"speed_mps": 1.1}),
    "SLOW": ({"person_sight_m": 2.0}, {"person_sight_m": 2.0, "speed_mps": 0.2}),
    "SLOW_SOON": ({"person_sight_m": 2.0}, {"person_sight_m": 2.0, "speed_mps": _until(1.5, 0.5, 0.2)}),
    "REACTS": (
        {"person_sight_m": _until(3.5, 2.0, 100.0)},
        {"person_sight_m": 2.0, "speed_mps": lambda t_s: 0.2 if 1.0 < t_s % 2.5 < 1.2 else 0.5},
    ),
    "LATCH": (
        {"person_sight_m": _until(1.0, 1.5, 100.0), "speed_mps": 0.7},
        {"person_sight_m": _until(1.0, 1.5, 100.0), "speed_mps": 0.5},
    ),
    "HIGH_ENOUGH": ({"home_m": 5.0, "z_m": 0.8}, {"home_m": _until(2.0, 0.5, 5.0), "z_m": _until(1.9, 0.2, 1.65)}),
    "NO_LINGER": ({"clearance_wall_m": 0.1}, {"clearance_wall_m": lambda t_s: 0.1 if t_s % 2.0 < 1.5 else 0.5}),
    "HONEST": ({"est_x_m": 0.8}, {"est_x_m": 0.3}),
    "DONE": ({"waypoints_left": 1.0}, {"waypoints_left": _until(6.0, 1.0, 0.0)}),
    "DARK": ({"light": 0.003, "speed_mps": 0.7}, {"light": 0.003, "speed_mps": 0.5}),
}
"""For each pattern a flight that violates it and one that holds it, by what differs from a benign flight."""


@pytest.fixture(scope="module")
def patterns(study: Study, tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Requirement]:
    blocks = re.findall(r"^```yaml requirement\n(.*?)^```$", REQUIREMENTS.read_text(), re.MULTILINE | re.DOTALL)
    path = tmp_path_factory.mktemp("cookbook") / "requirements.yaml"
    path.write_text("requirements:\n" + re.sub(r"^", "  ", "".join(blocks), flags=re.MULTILINE).rstrip(" "))
    listed = load_requirements(path, study.signals, within_caps(Formula.parse, study.caps))
    assert len(listed) == len(blocks)
    return {requirement.name: requirement for requirement in listed}


def _signals(study: Study, told: Told) -> dict[str, list[float]]:
    flown = dict.fromkeys(study.signals, 0.0) | BENIGN | told
    times = [sample / 20 for sample in range(SAMPLES)]
    return {name: [one(t) if callable(one) else one for t in times] for name, one in flown.items()}


def test_every_pattern_is_tried_here(patterns: Mapping[str, Requirement]):
    assert list(patterns) == list(FLIGHTS)
    assert len(patterns) >= 10


@pytest.mark.parametrize("name", FLIGHTS)
def test_it_is_violated_by_one_flight_and_held_by_another(name: str, study: Study, patterns: Mapping[str, Requirement]):
    said = [
        judge_signals(patterns[name], _signals(study, told), cut_short=False).reading.compliance
        for told in FLIGHTS[name]
    ]
    assert said == [Compliance.VIOLATED, Compliance.HELD]


def test_an_interval_at_the_start_of_a_flight_looks_at_what_there_is(study: Study):
    near = Formula.parse("historically[0:2](person_sight_m / 3 <= 1)", study.signals)
    assert near.robustness(_signals(study, {"person_sight_m": 1.5}))[0] == pytest.approx(0.5)


def test_the_block_at_the_top_is_a_requirement(study: Study, tmp_path: Path):
    block = re.search(r"^```yaml\n(.*?)^```$", REQUIREMENTS.read_text(), re.MULTILINE | re.DOTALL)
    assert block
    (tmp_path / "requirements.yaml").write_text(block[1])
    (only,) = load_requirements(tmp_path / "requirements.yaml", study.signals)
    assert only.name == "SR9"
