import os
import subprocess
import sys

import pytest
from processes import ROOT

from scaloft_fi.campaign.processes import LINUX, cores
from scaloft_fi.stack import kernel as kernel_module
from scaloft_fi.stack.kernel import jit, made_of, with_globals


def test_a_kernel_computes_what_its_function_says_and_divides_by_zero_as_numpy_does():
    inverse = jit(lambda x: 1.0 / x)
    assert (inverse(4.0), inverse(0.0)) == (0.25, float("inf"))


def test_without_a_place_for_the_cache_a_kernel_still_compiles(monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file"))
    assert jit(lambda x: 2 * x)(4) == 8


def test_machine_code_is_found_again_wherever_its_source_stands(monkeypatch, tmp_path):
    def kernel_at(folder, text):
        source, space = tmp_path / folder / "part.py", {}
        source.parent.mkdir(exist_ok=True)
        source.write_text(text)
        exec(compile(text, str(source), "exec"), space)
        kernel = jit(space["part"])
        assert kernel(3.0) == space["part"](3.0)
        return dict(kernel.stats.cache_hits), kernel

    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    text = "STEP = 2.0\ndef part(x):\n    return x * STEP\n"
    assert sum(kernel_at("one", text)[0].values()) == 0
    assert sum(kernel_at("two", f"# moved\n\n{text}")[0].values()) == 1
    assert sum(kernel_at("two", text.replace("2.0", "3.0"))[0].values()) == 0


@pytest.mark.parametrize(
    "other",
    [
        "STEP = 2.0\ndef own(x):\n    return x\ndef part(x):\n    return own(x) * STEP\n",
        "STEP = 1.0\ndef own(x):\n    return -x\ndef part(x):\n    return own(x) * STEP\n",
        "STEP = 1.0\ndef own(x):\n    return x\ndef part(x):\n    return own(x) + STEP\n",
        "__name__ = 'elsewhere'\nSTEP = 1.0\ndef own(x):\n    return x\ndef part(x):\n    return own(x) * STEP\n",
        "import numpy as np\nSTEP = np.zeros(2)\ndef own(x):\n    return x\ndef part(x):\n    return own(x) * STEP\n",
    ],
)
def test_what_a_kernel_is_made_of_are_its_code_its_constants_and_the_kernels_that_it_calls(other):
    def made(text):
        space = {}
        exec(text, space)
        space["own"] = jit(space["own"])
        return made_of(space["part"])

    text = "STEP = 1.0\ndef own(x):\n    return x\ndef part(x):\n    return own(x) * STEP\n"
    assert made(text) == made(f"# other lines\n{text}")
    assert made(text) != made(other)


def test_the_kernels_that_were_compiled_first_go_when_there_are_too_many(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(kernel_module, "MOST_KEPT", 2)
    for factor in (2.0, 3.0, 4.0, 5.0):
        kernel = jit(with_globals(_scaled, factor=factor))
        assert kernel(1.0) == factor
    assert len([*(tmp_path / "scaloft-fi" / "kernels").iterdir()]) == 3


def _scaled(x):
    return x * factor  # noqa: F821 - given by `with_globals`


def _applied(x):
    return kernel(x) + 1.0  # noqa: F821 - given by `with_globals`


def test_a_copy_with_other_globals_calls_other_kernels():
    def double(x):
        return 2.0 * x

    def half(x):
        return 0.5 * x

    one, other = (jit(with_globals(_applied, kernel=jit(kernel))) for kernel in (double, half))
    assert (one(4.0), other(4.0)) == (9.0, 3.0)


COLD = """
import sys
from scaloft_fi.campaign.flights import physics
from scaloft_fi.sim.flight import task_of
from scaloft_fi.stack import kernel
from scaloft_fi.study import Study

study = Study.open(sys.argv[1])
study.stack.kernels(task_of(study.sim, study.stack, study.scenario(study.grid.situations[0])))
save, late = kernel._Kept.save_overload, set()


def saved(kept, *rest):
    late.add(kept._function.__module__.rpartition(".")[2])
    save(kept, *rest)


kernel._Kept.save_overload = saved
begin, beside = physics._compiling, []
physics._compiling = lambda *asked: beside.append(begin(*asked)) or beside[0]
physics.Physics().prepare(study, print)
physics.Physics().prepare(study, print)
print(len(beside), beside[0] is not None, *late)
"""


@pytest.mark.release
def test_a_flight_compiles_no_kernel_that_a_process_beside_it_has_compiled(tmp_path):
    place = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(ROOT)}
    run = [sys.executable, "-c", COLD, str(ROOT)]
    done = subprocess.run(run, env=place, capture_output=True, text=True, check=True)
    asked, began, *late = done.stdout.splitlines()[-1].split()
    assert (asked, began) == ("1", str(LINUX and cores() > 1)), "where nothing is kept, and only there"
    assert "estimator" in late
    assert set(late) & {"memory", "planner", "proximity"} == set()
