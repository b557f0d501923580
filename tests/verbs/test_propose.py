"""`propose`: a requirement from a fault that violates none, tested on fresh seeds; and what it refuses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from options import cases
from printed import of_form, run

import scaloft_fi
from scaloft_fi.analysis.proposal import Candidate, Choice, Condition, Shape
from scaloft_fi.analysis.roster import Ratio
from scaloft_fi.campaign.flights.fly import Flight
from scaloft_fi.campaign.runs.propose import Tested as Proposal
from scaloft_fi.campaign.runs.propose import Told, _tested, candidates_of
from scaloft_fi.document import load
from scaloft_fi.judge.requirement import Kind, Requirement, load_requirements
from scaloft_fi.sim.situation import Situation
from scaloft_fi.study import Study
from scaloft_fi.verbs.first_screen import selected
from scaloft_fi.verbs.propose import drawn, entry, fresh_seeds

FAULT = "LATE-velcmd@0.5s"


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small study in which one fault was flown in one situation."""
    folder = tmp_path_factory.mktemp("propose") / "study"
    assert run("new", folder) == 0
    key = Study.open(folder).grid.situations[0].key
    words = ("--situation", key, "--mutant", FAULT, "--baseline-seeds", "10", "--quiet")
    assert run("run", "--study", folder, *words) == 0
    return folder


@pytest.mark.flight
def test_a_fault_that_violates_nothing_gets_a_requirement_that_fresh_flights_confirm(
    study: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    capsys.readouterr()
    words = ("--study", study, "--output", tmp_path / "entries.yaml", "--format", "json", "--quiet", "--jobs", "2")
    assert run("propose", *words) == 0
    told = of_form("propose", capsys.readouterr().out)
    (proposal,) = told["proposals"]
    assert (proposal["mutant"], proposal["confirmed"]) == (FAULT, True)
    assert proposal["p"] <= 0.01
    assert (told["same"], told["none"]) == ([], [])
    requirements = study / "sim" / "requirements.yaml"
    pasted = tmp_path / "requirements.yaml"
    pasted.write_text(requirements.read_text() + (tmp_path / "entries.yaml").read_text())
    read = {one.name: one for one in load_requirements(pasted, Study.open(study).signals)}
    (name,) = read.keys() - load(requirements).need("requirements").mapping().keys()
    assert (read[name].text, read[name].trigger) == (proposal["formula"], proposal["trigger"])
    assert (read[name].kind, read[name].proposed_from) == ("reported", FAULT)


def test_a_score_says_that_a_requirement_was_proposed_once_it_decides():
    made = Requirement("P-1", Kind.REPORTED, "always(clearance_m > 0)", proposed_from=FAULT)
    own = replace(made, kind=Kind.SAFETY, proposed_from="")
    for requirements, told in (((made, own), []), ((replace(made, kind=Kind.SAFETY), own), ["1 requirement was"])):
        clauses = selected(SimpleNamespace(selected=()), SimpleNamespace(requirements=requirements))
        assert [clause.partition(" proposed")[0] for clause in clauses] == told


@pytest.mark.flight
def test_of_too_few_flights_no_requirement_is_sought_and_the_seeds_that_do_are_told(
    study: Path, capsys: pytest.CaptureFixture[str]
):
    capsys.readouterr()
    words = ("propose", "--study", study, "--seeds", "1", "--quiet", "--jobs", "2")
    assert run(*words, "--format", "json") == 0
    told = of_form("propose", capsys.readouterr().out)
    few = {"mutant": FAULT, "traces": {"part": 1, "whole": 1}, "needed": 3, "seeds": 3}
    assert (told["few"], told["none"], told["proposals"]) == ([few], [], [])
    assert run(*words) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert f"no requirement was sought: {FAULT} (1/1, 3 needed; try `--seeds 3`)." in said
    assert "separates" not in said


@pytest.mark.release
@pytest.mark.flight
def test_python_proposes_in_new_processes_what_the_verb_proposes(study: Path, capsys: pytest.CaptureFixture[str]):
    found = scaloft_fi.open(study).campaign().propose(FAULT, seeds=2)
    capsys.readouterr()
    assert run("propose", FAULT, "--study", study, "--seeds", "2", "--format", "json", "--quiet") == 0
    assert found.record()["proposals"] == of_form("propose", capsys.readouterr().out)["proposals"]


def test_an_entry_of_each_template_reads_back(study: Path, tmp_path: Path):
    here = Study.open(study)
    candidates, none = candidates_of(here), Ratio(0, 1)
    entries, texts = "", {}
    for number, candidate in enumerate(
        one for one in candidates.listed if one.term == "abs(est_z_m - z_m)" and one.above
    ):
        trigger, formula = candidate.formula(0.25)
        choice, texts[f"P-{number}"] = Choice(candidate, 0.25, 1.0), (formula, trigger)
        made = choice.requirement(f"P-{number}", candidates.definitions)
        entries += entry(Proposal(str(number), choice, made, none, none, 0.0, True, True, ()))
    pasted = tmp_path / "requirements.yaml"
    pasted.write_text((study / "sim" / "requirements.yaml").read_text() + entries)
    read = {one.name: (one.text, one.trigger) for one in load_requirements(pasted, here.signals)}
    assert {name: read[name] for name in texts} == texts
    means = {one.sentence(0.25) for one in candidates.listed if one.shape is Shape.MEAN and not one.condition.words}
    assert "The mean of `abs(est_z_m - z_m)` over 3 s is never above 0.25 m." in means


@given(st.text(max_size=5), st.lists(st.text(max_size=3), unique=True, max_size=9), st.integers(1, 9))
def test_at_most_so_many_situations_are_drawn_in_their_order_and_always_the_same(
    subject: str, keys: list[str], most: int
):
    found = drawn(subject, keys, most)
    assert found == drawn(subject, keys, most)
    assert list(found) == [key for key in keys if key in found]
    assert len(found) == min(most, len(keys))


def test_many_subjects_draw_all_situations_of_a_grid():
    keys = [str(number) for number in range(32)]
    assert {key for subject in range(20) for key in drawn(str(subject), keys, 8)} == set(keys)


CHOICE = Choice(Candidate("z_m", True, Shape.SAMPLE, 0.0, Condition("", ""), "m"), 2.5, 1.0)


@pytest.mark.parametrize(("seeds", "firm"), [({50, 51, 52}, True), ({50}, False)])
def test_a_requirement_that_hangs_on_one_seed_is_confirmed_and_not_firm(seeds: set[int], firm: bool):
    def flown(violating: set[int], numbers: range) -> list[Told]:
        situations = (Situation(str(key), (("T", key),)) for key in range(8))
        return [Told(Flight(None, one, s), violated=(s in violating,)) for one in situations for s in numbers]

    told = {"A": flown(seeds, range(50, 53)), "B": flown(set(), range(50, 53))}
    requirement = CHOICE.requirement("P-A", ())
    (tested,) = _tested({"A": CHOICE}, {"A": requirement}, told, flown(set(), range(50, 60)), 0.01)
    assert (tested.confirmed, tested.firm, tested.others) == (True, firm, ())
    assert (tested.shown.part, tested.shown.whole, tested.alarms.whole) == (8 * len(seeds), 24, 80)


def test_no_seed_of_the_choice_is_in_the_test_though_the_campaign_flew_few():
    for flown in ([0], [0, 4], [12, 13]):
        now = SimpleNamespace(outcomes=[SimpleNamespace(seed=seed) for seed in flown])
        seeds = fresh_seeds(now, 3)
        assert not {*seeds.fresh, *seeds.fresh_pool} & {*flown, *seeds.chosen, *seeds.chosen_pool}
        assert (len(seeds.fresh), len(seeds.fresh_pool)) == (len(seeds.chosen), len(seeds.chosen_pool))


@cases("words", "said")
def test_what_it_cannot_propose_for_is_refused_in_a_sentence(
    study: Path, words: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
):
    assert run("propose", "--study", study, *words) == 2
    assert said in capsys.readouterr().err
