"""The rules of the house, each as the command that holds it: this file is the whole lint run."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from scaloft_fi.campaign.workers import Interrupted
from scaloft_fi.errors import ExitCode, GateError, InputError, ScaloftError

ROOT = Path(__file__).resolve().parents[1]

SCRIPTS = [
    path for folder in ("benchmarks", "experiments", "docs/hooks") for path in sorted((ROOT / folder).rglob("*.py"))
]
USER_SCRIPT = ROOT / "tests" / "support" / "user_script.py"
MYPY_SCRIPTS = ("--explicit-package-bases", *map(str, (*SCRIPTS, USER_SCRIPT)))
SLOW = ("mypy --strict finds nothing", "mypy --strict finds nothing in the scripts")
COMMANDS = {
    "ruff finds nothing": ["-m", "ruff", "check"],
    "every file is formatted": ["-m", "ruff", "format", "--check"],
    SLOW[0]: ["-m", "mypy"],
    SLOW[1]: ["-m", "mypy", *MYPY_SCRIPTS],
    "imports run one way": ["-c", "from importlinter.cli import lint_imports_command; lint_imports_command()"],
}


@pytest.mark.parametrize(
    "rule", [pytest.param(rule, marks=[pytest.mark.release] if rule in SLOW else []) for rule in COMMANDS]
)
def test_the_rule_holds(rule: str):
    done = subprocess.run([sys.executable, *COMMANDS[rule]], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_data_folder_is_never_a_package():
    inits = [path for folder in ("hazop", "mutants", "sim", "results") for path in (ROOT / folder).rglob("__init__.py")]
    assert inits == []


def test_tests_are_not_a_package():
    assert list((ROOT / "tests").rglob("__init__.py")) == []


READERS = {
    "document.py": "the one reader; /proc, and the pipe of the process that it forks",
    "sources.py": "source files of packages",
    "campaign/store/platforms.py": "/proc/cpuinfo",
    "verbs/report/page.py": "files of this package",
    "sim/build.py": "the null device",
    "campaign/runs/gates.py": "files of this package",
    "campaign/store/store.py": "the file of the store, to watch it",
    "output.py": "the standard streams, and the files that it writes",
    "verbs/doctor.py": "/proc/meminfo",
    "outside/exchange.py": "the output of its processes, which the guard bounds",
    "outside/guard.py": "the output of its processes, and /proc",
    "outside/suite.py": "the file to which the flights of one test add what a fault altered",
    "views/table.py": "a file of this package",
    "hazop/sheet.py": "files of this package",
}
"""The modules that open files, and which."""
NO_FILES = {"Study", "archive", "border", "self._lines", "windows", "own.windows", "stream"}
"""What has a method `open` that opens no file that a user names."""


def _opens(node: ast.AST) -> bool:
    if not isinstance(node, ast.Call):
        return False
    owner, _, name = ast.unparse(node.func).rpartition(".")
    if name in {"read_text", "read_bytes"}:
        return bool(owner) and owner not in NO_FILES  # without an owner it is the function of `document.py`
    return name in {"open", "fdopen"} and owner not in NO_FILES


def test_one_module_opens_the_files_of_users():
    package = ROOT / "scaloft_fi"
    opening = {
        path.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        if any(map(_opens, ast.walk(ast.parse(path.read_text()))))
    }
    assert opening == set(READERS)


def test_every_module_says_what_it_is():
    modules = (ROOT / "scaloft_fi").rglob("*.py")
    silent = [str(path) for path in modules if not path.read_text().startswith(('"""', 'r"""'))]
    assert silent == []


PLUGINS = ("templates", "examples/own_stack", "examples/ros1")


def test_what_we_show_as_plugins_imports_the_public_names_alone():
    found = {
        f"{path.relative_to(ROOT)}: {node.module}"
        for folder in PLUGINS
        for path in (ROOT / folder).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("scaloft_fi.")
    }
    assert {said.rpartition(": ")[2] for said in found} == {"scaloft_fi.api"}, sorted(found)


def test_each_error_ends_with_a_code_that_has_a_meaning():
    assert [error.exit_code for error in (ScaloftError, InputError, GateError, Interrupted)] == [
        *(ExitCode.INTERNAL, ExitCode.BAD_INPUT, ExitCode.GATE, ExitCode.INTERRUPTED)
    ]
    assert all(code.meaning.endswith(".") for code in ExitCode)


def test_no_error_of_the_package_ends_with_another_code():
    codes = {
        node.value.value
        for path in (ROOT / "scaloft_fi").rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Assign)
        and isinstance(node.value, ast.Constant)
        and any(isinstance(target, ast.Name) and target.id == "exit_code" for target in node.targets)
    }
    assert codes == {70, 2, 4, 130}
