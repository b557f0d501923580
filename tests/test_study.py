"""A study: where it is found, what its keys are made of, what it accepts."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from datetime import date
from functools import partial
from importlib import import_module
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from builders import GRID
from options import cases
from refused import refusal
from studies import ROOT, edit_in

from scaloft_fi.analysis.survivor import Disposition
from scaloft_fi.errors import InputError
from scaloft_fi.hazop.load import load_matrix
from scaloft_fi.mutants.operators import OPERATORS
from scaloft_fi.registry import PLUGIN_GROUP
from scaloft_fi.sim.happenings import HAPPENINGS, Effect, HappeningKind, Surroundings
from scaloft_fi.sim.world import ROLES
from scaloft_fi.sources import closure
from scaloft_fi.stack.reference.declaration import REFERENCE
from scaloft_fi.study import PACKAGE, Study, append_drafts, draft, load_dispositions


def test_the_reference_study_passes_every_check(study: Study):
    study.check()
    assert len(study.grid) == 32
    assert len(study.space.points) == 32


def test_the_study_is_the_nearest_folder_upwards(copy: Path, monkeypatch: pytest.MonkeyPatch):
    (copy / "deep" / "deeper").mkdir(parents=True)
    monkeypatch.chdir(copy / "deep" / "deeper")
    assert Study.open().folder == copy
    assert Study.open().results_folder == copy / "results"


def test_the_package_itself_is_no_study(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(PACKAGE)
    assert Study.open().folder == ROOT


def test_a_packaged_study_keeps_its_results_where_the_user_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    assert Study(PACKAGE / "_study").results_folder == tmp_path / "results"


def test_a_situation_changes_what_its_values_set_and_nothing_else(study: Study):
    assert study.changes(study.grid.situation("T0O0W0D0H0")) == {}
    dark = study.changes(study.grid.situation("T0O0W0D1H1"))
    assert set(dark) == {"world.light", "world.bodies.person.present"}


def test_the_time_expected_of_a_flight_grows_with_the_route_and_a_person(study: Study):
    straight, turn, slow = (
        study.expected_s(study.grid.situation(key)) for key in ("T0O0W0D0H0", "T1O0W0D0H0", "T1O0W0D0H1")
    )
    assert straight < turn < slow


def test_who_asks_for_names_and_keys_reads_no_mine_and_who_flies_does(study: Study, monkeypatch: pytest.MonkeyPatch):
    def unread(_item):
        raise InputError("the mine was read")

    again = Study.open(study.folder)
    for module in ("grid", "world"):
        monkeypatch.setattr(f"scaloft_fi.sim.{module}.read_mine", unread)
    assert (again.signals, again.catalogue, again.inputs) == (study.signals, study.catalogue, study.inputs)
    with pytest.raises(InputError, match="the mine was read"):
        _ = again.sim


def test_formulas_are_proved_wherever_requirements_are_read(copy: Path):
    edit_in(copy / "sim" / "requirements.yaml", "speed_mps / 0.25", "speed_mps 0.25")
    for read in (lambda: Study(copy).requirements, Study(copy).check):
        with pytest.raises(InputError, match=r"requirements.yaml:\d+: .* is not a formula"):
            read()


def test_what_requirements_are_called_in_words_changes_no_hash(copy: Path):
    before = Study(copy).inputs
    path = copy / "sim" / "requirements.yaml"
    text = path.read_text()
    path.write_text(re.sub(r"(?m)^(    title: ).*$", r"\1other words", text))
    assert path.read_text() != text
    assert Study(copy).inputs == before


def test_a_predicate_judges_the_situations_with_its_value_and_the_benign_ones_of_its_axis(copy: Path):
    before = {s.key: Study(copy).realised(s) for s in Study(copy).grid.situations}
    edit_in(copy / "sim" / "situations.yaml", "eventually(x_m < -1)", "eventually(x_m < -2)")
    study = Study(copy)
    assert all(study.realised(s)["T"] != before[s.key]["T"] for s in study.grid.situations)
    assert all(study.realised(s)[axis] == before[s.key][axis] for s in study.grid.situations for axis in "OWDH")


def test_a_comment_changes_no_hash(copy: Path):
    before = Study(copy).inputs
    for path in (copy / "sim").glob("*.yaml"):
        path.write_text(f"# a comment\n{path.read_text()}")
    assert Study(copy).inputs == before


@pytest.mark.parametrize(("change", "moves"), [({"label": "dog"}, True), ({"fill": "#000000"}, False)])
def test_how_detector_and_observer_treat_a_role_is_part_of_the_hash_and_its_colour_is_not(
    copy: Path, monkeypatch: pytest.MonkeyPatch, change: dict[str, str], moves: bool
):
    before = Study(copy).inputs["sim"]
    monkeypatch.setitem(ROLES._entries, "person", replace(ROLES["person"], **change))
    assert (Study(copy).inputs["sim"] != before) is moves


@pytest.fixture
def plugin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of an installed package that declares the operator `wander` and keeps its rate in a second module."""
    folder = tmp_path / "site" / "mine_faults"
    folder.mkdir(parents=True)
    (folder / "__init__.py").touch()
    (folder / "rates.py").write_text("RATE = 0.1\n")
    (folder / "wander.py").write_text("from mine_faults.rates import RATE\ndef make(_context):\n    return RATE\n")
    monkeypatch.syspath_prepend(folder.parent)
    for name in ("mine_faults", "mine_faults.rates", "mine_faults.wander"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    make = import_module("mine_faults.wander").make
    known = {name: OPERATORS[name] for name in OPERATORS}
    monkeypatch.setattr(OPERATORS, "_entries", {**known, "wander": replace(known["delay"], name="wander", make=make)})
    return folder


def test_an_edit_of_a_plugin_changes_the_hash_of_its_operator_and_a_comment_in_it_does_not(copy: Path, plugin: Path):
    before = Study(copy).inputs
    edit_in(copy / "hazop" / "matrix" / "human.yaml", "operator: drop", "operator: wander")
    used = Study(copy).inputs
    (plugin / "rates.py").write_text("RATE = 0.1  # a comment\n")
    assert Study(copy).inputs == used == {**before, "operator wander": used["operator wander"]}
    (plugin / "rates.py").write_text("RATE = 0.2\n")
    edited = Study(copy).inputs
    assert {part for part in used if edited[part] != used[part]} == {"operator wander"}


def test_an_edit_of_the_library_or_of_a_data_file_of_a_plugin_changes_the_hash_of_its_operator(
    copy: Path, plugin: Path
):
    edit_in(copy / "hazop" / "matrix" / "human.yaml", "operator: drop", "operator: wander")
    library, data = plugin.parent / "mine_lab.py", plugin / "gain.txt"
    (plugin / "rates.py").write_text("from mine_lab import RATE\n")
    found = []
    for path, text in ((library, "RATE = 0.1\n"), (library, "RATE = 0.2\n"), (data, "1.0"), (data, "0.5")):
        path.write_text(text)
        found.append(Study(copy).inputs)
    assert len({inputs["operator wander"] for inputs in found}) == len(found)
    assert len({inputs["code"] for inputs in found}) == 1


def test_a_plugin_enters_the_hash_of_what_it_declares_by_a_function_of_a_library(
    copy: Path, plugin: Path, monkeypatch: pytest.MonkeyPatch
):
    edit_in(copy / "hazop" / "matrix" / "human.yaml", "operator: drop", "operator: wander")
    monkeypatch.setattr("scaloft_fi.study.plugins", lambda: (EntryPoint("mine", "mine_faults.wander", PLUGIN_GROUP),))
    monkeypatch.setitem(
        OPERATORS._entries, "wander", replace(OPERATORS["wander"], make=partial(OPERATORS["drop"].make))
    )
    monkeypatch.setitem(OPERATORS.declared_in, "wander", "mine_faults.wander")
    before = Study(copy).inputs
    (plugin / "rates.py").write_text("RATE = 0.2\n")
    assert Study(copy).inputs["operator wander"] != before["operator wander"]


def test_an_edit_of_a_kind_of_happening_changes_the_hash_of_the_code_where_the_world_has_it(
    copy: Path, plugin: Path, monkeypatch: pytest.MonkeyPatch
):
    class Nothing(Effect):
        def apply(self, around: Surroundings, since_s: float) -> None:
            pass

    Nothing.__module__ = "mine_faults.wander"
    monkeypatch.setitem(HAPPENINGS._entries, "wandering", HappeningKind(Nothing))
    before = Study(copy).inputs["code"]
    with (copy / "sim" / "world.yaml").open("a") as file:
        file.write("\nhappenings: {h: {kind: wandering, active: false}}\n")
    used = Study(copy).inputs["code"]
    (plugin / "rates.py").write_text("RATE = 0.2\n")
    assert len({before, used, Study(copy).inputs["code"]}) == 3


def test_a_plugin_that_the_study_does_not_use_changes_no_hash(copy: Path, plugin: Path):
    before = Study(copy).inputs
    (plugin / "rates.py").write_text("RATE = 0.2\n")
    assert Study(copy).inputs == before


def test_the_code_that_enters_keys_flies_and_judges_and_shows_nothing(study: Study):
    """A change of a table, a view, a score or the command line makes no flight stale."""
    folders = {source.path.parent.relative_to(PACKAGE).as_posix() for source in closure(study.flying_modules).values()}
    assert {folder for folder in folders if not folder.startswith(("sim", "stack", "mutants", "judge"))} == {
        *(".", "hazop", "campaign", "campaign/flights")
    }


def test_the_code_that_enters_keys_leaves_out_how_flights_are_planned_stored_and_handed_out(study: Study):
    names = {name.removeprefix("scaloft_fi.") for name in closure(study.flying_modules)}
    assert {"setup", "document", "registry", "sim.flight", "judge.outcome", "mutants.wire"} <= names
    assert not {"study", "campaign.plan", "campaign.pool", "mutants.catalogue", "hazop.load"} & names
    assert not {name for name in names if name.startswith(("mutants.operators", "mutants.reference"))}


def test_the_code_of_a_mutant_adds_the_module_of_its_operator_and_no_other_operator(study: Study):
    shared, modules = closure(study.flying_modules), study.operator_modules
    packages = {"scaloft_fi.mutants.operators", "scaloft_fi.mutants.reference"}
    for module in set(modules.values()):
        added = closure([module], beside=shared).keys()
        assert added >= {module}
        assert not added & {*modules.values()} - {module}
        assert {name for name in added if name.rpartition(".")[0] in packages} == {module}


def test_what_a_plugin_imports_of_the_api_brings_no_code_of_tables_scores_or_runs(study: Study):
    added = closure(["scaloft_fi.api"], beside=closure(study.flying_modules)).keys()
    assert {name.split(".")[1] for name in added} <= {"api", "mutants", "sim", "stack"}


@pytest.mark.flight
@pytest.mark.parametrize("subject", ["None", "PLACEBO"])
def test_nothing_is_imported_to_fly_and_judge_that_does_not_enter_keys(study: Study, subject: str):
    """A stack's own operators are declared in every flight, and none is made in a baseline."""
    program = """
import sys
from scaloft_fi.campaign.flights.fly import judged, wire_of
from scaloft_fi.campaign.flights.fly import Flight as Planned
from scaloft_fi.mutants.mutant import PLACEBO
from scaloft_fi.setup import Setup
from pathlib import Path
setup = Setup(Path(sys.argv[1]))
from scaloft_fi.sim import flight

subject = {"None": None, "PLACEBO": PLACEBO}[sys.argv[2]]
planned = Planned(subject, setup.grid.situations[0], 0)
with flight.physics_server() as client:
    short = flight.FlightLoop(client, setup.sim, setup.scenario(planned.situation), 0, wire_of(setup, planned))
    for _ in range(5):
        short.tick()
        short.advance()
    judged(setup, planned, short.log())
    judged(setup, Planned(None, planned.situation, 0), short.log())
print(*(name for name in sys.modules if name.startswith("scaloft_fi.")))
"""
    done = subprocess.run([sys.executable, "-c", program, ROOT, subject], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    imported = set(done.stdout.split("\n")[-2].split())
    assert "scaloft_fi.judge.outcome" in imported
    imported.discard("scaloft_fi.defaults")  # the root of the package imports this number, which changes no flight
    made = () if subject == "None" else study.operator_modules.values()
    declared = [name for name in imported if name.startswith("scaloft_fi.mutants.reference.")]
    assert declared
    assert imported <= closure([*study.flying_modules, *made]).keys() | closure(declared).keys()


MATRIX = load_matrix(Path(__file__).parents[1] / "hazop", REFERENCE.by_name)
KEYS = [key for key, _ in GRID.points]
GOOD = """\
LATE-human:
  status: accepted
  owner: A. Engineer
  reason: walking pace is slow enough there
  expires: 2027-01-31
  situations: [T0O0W0D0H1]
"""
DAY = date(2027, 1, 31)


def loaded(folder: Path, text: str) -> tuple[Disposition, ...]:
    path = folder / "dispositions.yaml"
    path.write_text(text, encoding="utf-8")
    return load_dispositions(path, MATRIX, KEYS)


def test_a_study_without_the_file_has_accepted_nothing(tmp_path: Path):
    assert load_dispositions(tmp_path / "dispositions.yaml", MATRIX, KEYS) == ()


def test_a_bare_cell_is_its_default_and_the_place_is_remembered(tmp_path: Path):
    (only,) = loaded(tmp_path, GOOD)
    assert (only.mutant, only.expires, only.situations) == ("LATE-human@3s", DAY, ("T0O0W0D0H1",))
    assert only.place.endswith("dispositions.yaml:1")


@cases("old", "new", "says")
def test_what_it_does_not_understand_it_refuses_with_the_place(tmp_path: Path, old: str, new: str, says: str):
    told = refusal(loaded, tmp_path, GOOD.replace(old, new))
    assert says in told
    assert "dispositions.yaml:" in told


@pytest.mark.parametrize("again", ["LATE-human", "LATE-human@3s", "LATE-human@3.0s"])
def test_a_mutant_that_stands_twice_is_refused_however_it_is_written(tmp_path: Path, again: str):
    for second in (GOOD.replace("LATE-human", again), f"{again}:\n  status: to_do\n"):
        for text in (GOOD + second, second + GOOD):
            with pytest.raises(InputError, match=r"twice|already at"):
                loaded(tmp_path, text)


def test_a_draft_accepts_nothing_until_it_is_decided(tmp_path: Path):
    text = draft(["LATE-human@3s", "NO-human@100%"])
    assert loaded(tmp_path, text) == ()
    with pytest.raises(InputError, match="'owner'"):
        loaded(tmp_path, text.replace("to_do", "accepted"))
    (entry,) = loaded(tmp_path, text.replace("to_do", "accepted\n  owner: me\n  reason: why\n  expires: 2027-01-31", 1))
    assert entry.mutant == "LATE-human@3s"


def test_a_second_draft_adds_only_what_has_no_entry(tmp_path: Path):
    path = tmp_path / "dispositions.yaml"
    path.write_text(GOOD, encoding="utf-8")
    assert append_drafts(path, MATRIX, ["LATE-human@3s", "NO-human@100%"]) == ["NO-human@100%"]
    written = path.read_text(encoding="utf-8")
    assert append_drafts(path, MATRIX, ["NO-human@100%"]) == []
    assert path.read_text(encoding="utf-8") == written
