from __future__ import annotations

from pathlib import Path

import pytest

from scaloft_fi.errors import InputError
from scaloft_fi.outside.border import Motion
from scaloft_fi.outside.command import Text, load_command
from scaloft_fi.stack.reference.declaration import REFERENCE

GOOD = {
    "flyer": "command",
    "run": '[fly, "{situation}", 5]',
    "record": "flight.csv",
    "limit_s": "60",
}


def _load(tmp_path: Path, **keys: str):  # type: ignore[no-untyped-def]
    path = tmp_path / "flyer.yaml"
    path.write_text("".join(f"{key}: {text}\n" for key, text in (GOOD | keys).items() if text))
    return load_command(path)


def test_a_declaration_is_read_and_is_not_deterministic_unless_it_says_so(tmp_path: Path) -> None:
    command = _load(tmp_path)
    assert [word.text for word in command.run] == ["fly", "{situation}", "5"]
    assert (command.limit_s, command.mission_s, command.deterministic) == (60.0, None, False)
    assert _load(tmp_path, deterministic="true").deterministic


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"run": "[]"}, "a list that begins with a program"),
        ({"record": "../flight.csv"}, "the name of a file, without a folder"),
        ({"inputs": "[/etc/passwd]"}, "the path of a file inside the study"),
        ({"seams": "{person: {parameter: false}}"}, "{parameter: true}, so that"),
        ({"seams": "{person: {parameter: true, message: velocty}}"}, "did you mean 'velocity'"),
        ({"seams": "{every: {parameter: true, message: velocity}}"}, "it stands for the seams of the stack"),
        ({"seams": "{x: {relay: {from: /x, to: /x, border: lines}}}"}, "between two topics"),
        ({"seams": "{x: {relay: {from: /x, to: /y, border: lnes}}}"}, "did you mean 'lines'"),
        ({"seams": "{x: {parameter: true, relay: {from: /x, to: /y, border: lines}}}"}, "{parameter: true}, so that"),
    ],
)
def test_a_wrong_declaration_is_refused_with_its_line(keys: dict[str, str], said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"flyer\.yaml:\d+: ") as refused:
        _load(tmp_path, **keys)
    assert said in str(refused.value)


def test_the_matrix_may_use_the_declared_seams_only(tmp_path: Path) -> None:
    command = _load(tmp_path, seams="{person: {parameter: true}, own: {parameter: true, message: velocity}}")
    narrowed = command.declared(REFERENCE)
    assert set(narrowed.by_name) == {"person", "own"}
    assert narrowed.by_name["own"].message is Motion
    assert not narrowed.deterministic
    every = _load(tmp_path, seams="{every: {parameter: true}}").declared(REFERENCE)
    assert every.by_name == REFERENCE.by_name
    assert every.canaries == REFERENCE.canaries


def test_a_seam_without_a_message_must_be_one_of_the_stack(tmp_path: Path) -> None:
    command = _load(tmp_path, seams="{persn: {parameter: true}}")
    with pytest.raises(InputError, match=r"'persn' is no seam of the stack 'reference'.*did you mean 'person'"):
        command.declared(REFERENCE)


def test_places_are_filled_with_values_and_other_braces_stay() -> None:
    values = {"seed": 3, "vehicle.mass_kg": 1.5, "dark": True, "situation": "T0"}
    text = Text('{situation}/{seed} {vehicle.mass_kg} {dark} {"a": {}}', "flyer.yaml:3")
    assert text.filled(values) == 'T0/3 1.5 true {"a": {}}'
    with pytest.raises(InputError, match=r"flyer\.yaml:3: there is no value \{sead\}; did you mean 'seed'"):
        Text("{sead}", "flyer.yaml:3").filled(values)
