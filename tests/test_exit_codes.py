from __future__ import annotations

import ast
from pathlib import Path

from scaloft_fi.campaign.workers.local import Interrupted
from scaloft_fi.errors import ExitCode, GateError, InputError, ScaloftError

PACKAGE = Path(__file__).parents[1] / "scaloft_fi"


def test_each_error_ends_with_a_code_that_has_a_meaning() -> None:
    assert [error.exit_code for error in (ScaloftError, InputError, GateError, Interrupted)] == [
        *(ExitCode.INTERNAL, ExitCode.BAD_INPUT, ExitCode.GATE, ExitCode.INTERRUPTED)
    ]
    assert all(code.meaning.endswith(".") for code in ExitCode)


def test_no_error_of_the_package_ends_with_another_code() -> None:
    codes = {
        node.value.value
        for path in PACKAGE.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Assign)
        and isinstance(node.value, ast.Constant)
        and any(isinstance(target, ast.Name) and target.id == "exit_code" for target in node.targets)
    }
    assert codes == {70, 2, 4, 130}
