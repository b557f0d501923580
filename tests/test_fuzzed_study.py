"""Every study is read, or refused in one sentence, at once: inputs changed by chance, and inputs that once did harm."""

from __future__ import annotations

import json
import time
from pathlib import Path

import pytest
from fuzzing import CORPUS, MOST_S, WORLD, probe, told, wrong_sentence
from options import usually
from processes import ROOT, call, install_project
from studies import copied

from scaloft_fi.errors import InputError
from scaloft_fi.sim.grid import load_grid
from scaloft_fi.study import Study

SEEDS = usually(8, release=500)
OWN = ROOT / "examples" / "own_stack"


def meshed(folder: Path) -> Path:
    """Copy the reference study with its mine as a mesh, an accepted survivor and a constraint."""
    copied(folder)
    mine, lines, count = load_grid(ROOT / "sim").world(()).mine, [], 1
    for name, part in (("rock", mine.wall), ("floor", mine.ground)):
        lines += [f"o {name}", *(f"v {x:g} {y:g} {z:g}" for x, y, z in part.vertices)]
        lines += [f"f {' '.join(map(str, face))}" for face in part.faces + count]
        count += len(part.vertices)
    (folder / "sim" / "room.obj").write_text("\n".join([*lines, ""]))
    world = folder / "sim" / "world.yaml"
    begin, rest = world.read_text().split("  footprint:")
    mesh = "  mesh: room.obj\n  scale_m: 1.0\n  ground: [floor]\n  mesh_limits: {triangles: 10_000, corners: 10}\n"
    world.write_text(f"{begin}{mesh}  wall_reflectivity{rest.split('  wall_reflectivity')[1]}")
    with (folder / "sim" / "situations.yaml").open("a") as file:
        file.write("constraints:\n  - {exclude: {T: 0, O: 1}, reason: none}\n")
    accepted = "{status: accepted, owner: a, reason: b, expires: 2027-01-31, situations: [T0O0W0D0H1]}"
    (folder / "hazop" / "dispositions.yaml").write_text(f"LATE-human: {accepted}\n")
    return folder


@pytest.mark.parametrize("name", ["reference", "meshed", "own"])
def test_a_study_changed_by_chance_is_read_or_refused_in_one_sentence(tmp_path, name):
    study = {"reference": ROOT, "own": OWN / "study"}.get(name) or meshed(tmp_path / name)
    install_project(tmp_path / "site", OWN)
    done = call(tmp_path / "site", ROOT / "tests" / "support" / "fuzzing.py", study, "0", str(SEEDS), cwd=tmp_path)
    assert done.returncode == 0, done.stderr[-2000:]
    assert json.loads(done.stdout) == {}


@pytest.fixture(scope="module")
def study(tmp_path_factory) -> Path:
    probe(study := meshed(tmp_path_factory.mktemp("studies") / "meshed"))  # imports what the tests must not measure
    return study


@pytest.mark.parametrize("name", CORPUS)
def test_an_input_that_once_did_harm_is_refused_at_once(study, tmp_path, name):
    file, change, sentence = CORPUS[name]
    copied(tmp_path, study=study)
    change(tmp_path / file)
    begun_s = time.process_time()
    with pytest.raises(InputError, match=sentence) as error:
        probe(tmp_path)
    assert time.process_time() - begun_s < MOST_S
    assert not wrong_sentence(str(error.value))


def test_a_refused_study_ends_a_verb_with_one_sentence_and_code_2(study, tmp_path):
    copied(tmp_path, study=study)
    (tmp_path / WORLD).write_text("[" * 30_000)
    assert not told(tmp_path, ("mutants", "--check"))


@pytest.mark.parametrize("name", ["a" * 300, "~nosuchuser", "a\0b"])
def test_a_study_that_the_system_refuses_by_name_is_none(tmp_path, name):
    with pytest.raises(InputError, match="must be a folder with hazop/, mutants/ and sim/"):
        Study.open(tmp_path / name)


def test_a_current_folder_that_was_deleted_is_told(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    tmp_path.rmdir()
    with pytest.raises(InputError, match="the current folder cannot be read"):
        Study.open()
