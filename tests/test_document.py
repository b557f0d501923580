"""Documents, and the keys that YAML would read as something else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from options import cases
from refused import refusal

from scaloft_fi.document import ITEMS, edited, load
from scaloft_fi.errors import InputError


@pytest.fixture
def read(tmp_path):
    def write_and_load(text):
        path = tmp_path / "a.yaml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return load(path)

    return write_and_load


def test_every_value_knows_its_line_and_a_mapping_stands_where_its_key_does(read):
    document = read("one: 1\ntwo:\n  three: [1,\n    2]\n")
    assert document.need("one").line == 1
    assert document.need("two").line == 2
    assert document.need("two").need("three").line == 3
    assert document.need("two").need("three").items()[1].line == 4


def test_a_bare_word_is_a_key_whatever_yaml_makes_of_it(read):
    assert set(read("NO: 1\n'on': 2\n1.5: 3\n").mapping()) == {"NO", "on", "1.5"}


def test_plain_gives_the_bare_values_back(read):
    assert read("a: [1, 2.5, x, true, null]\nb: {c: d}\n").plain() == {"a": [1, 2.5, "x", True, None], "b": {"c": "d"}}


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "a.yaml:1: the file is empty"),
        ("a: [1\n", "a.yaml:2: not valid YAML"),
        ("a: 1\na: 2\n", "a.yaml:2: key 'a' occurs twice"),
        ("a: !!python/object:os.system x\n", "a.yaml:1: a has the tag 'tag:yaml.org,2002:python/object:os.system'"),
        ("a:\n\tb: 1\n", "a.yaml:2: not valid YAML: a tab stands where YAML takes only spaces; write spaces instead"),
        ("a:\n  - b: 1\n  \t- c: 1\n", "a.yaml:3: not valid YAML: a tab"),
        ("a: 1\n\tb: 1\n", "a.yaml:2: not valid YAML: a tab"),
        ("a:\t\t@b\n", "a.yaml:1: not valid YAML: found character"),
        ("a: @b\n", "a.yaml:1: not valid YAML: found character that cannot start any token"),
        (
            "a: 1\nb: A person: late.\n",
            "a.yaml:2: not valid YAML: ': ' stands where no key can; put a text with ': ' in",
        ),
        ("a: &x [*x]\n", "a.yaml:1: a[0] contains itself"),
        ("? [1, 2]\n: 3\n", "a.yaml:1: a key of a.yaml must be a single word"),
        (b"\xff\xfe\x00", "cannot be read: not UTF-8 text"),
    ],
)
def test_what_cannot_be_read_is_refused_with_its_line(read, text, sentence):
    assert sentence in refusal(read, text)


def test_an_alias_stands_for_a_copy_that_knows_its_own_name_and_place(read):
    document = read("one: &a {b: [1, &c 2]}\ntwo: *a\nthree: *c\n")
    assert document.need("two").plain() == {"b": [1, 2]}
    assert (document.need("two").line, document.need("two").name) == (2, "two")
    assert document.need("three").number() == 2


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("a: *b\n", "a.yaml:1: alias 'b' has no anchor above it"),
        ("a: !!str 1\n", "a.yaml:1: a has the tag 'tag:yaml.org,2002:str'; write the value without a tag"),
        ("!x a: 1\n", "a key of a.yaml must be a single word"),
        ("a: 1\n---\nb: 1\n", "a.yaml:2: a second document must stand in a file of its own"),
        ("a:\n  b: " + "1" * 101, "a.yaml:2: b='1"),
        ("a: &a [1]\nb: [*a,\n *a]\nc: " + "[" * 50 + "*a" + "]" * 50, "a.yaml:4: the file must be nested at most 50"),
    ],
)
def test_what_exceeds_a_limit_is_refused_with_its_line(read, text, sentence):
    assert sentence in refusal(read, text)


def test_a_document_of_the_largest_depth_and_number_of_values_is_read(read):
    assert read("[" * 50 + "]" * 50).items()
    assert len(read(f"[{'1,' * (ITEMS - 1)}]").items()) == ITEMS - 1
    with pytest.raises(InputError, match="must have at most 30,000 values"):
        read(f"[{'1,' * ITEMS}]")


def test_the_same_text_read_again_has_its_own_place(tmp_path: Path):
    first, second = tmp_path / "one" / "a.yaml", tmp_path / "two" / "a.yaml"
    for path in (first, second):
        path.parent.mkdir()
        path.write_text("size: {height: 1}\n")
    assert [load(path).need("size").place for path in (first, second)] == [f"{path}:1" for path in (first, second)]


WRITTEN = """# head
LATE:
  status: credible   # why
  deviation: Late, by
    two lines.
  effect: >-
    a folded
    text
  # a comment
  causes:
    - one  # c1
    - "two"
  team: {safeguards: none}

WORN:
  team: {safeguards: none, likelihood: 2, due: soon}
MILD:
  team:
    due: soon
BARE: {status: to_do}  # ask Anna
OPEN: {team: {}}

NO:
  effect: x
"""


@cases("steps", "value", "before", "after")
def test_an_edit_changes_one_value_and_nothing_else(
    steps: tuple[str | int, ...], value: str | dict[str, Any] | None, before: str, after: str
):
    assert edited(WRITTEN, steps, value, "a.yaml") == WRITTEN.replace(before, after)


def test_a_document_with_an_infinite_number_is_edited_too():
    assert edited("a: [1, .inf]\nb: one\n", ("b",), "two", "a.yaml") == "a: [1, .inf]\nb: two\n"


def test_what_would_change_something_else_too_is_not_edited():
    with pytest.raises(InputError, match="edit it by hand"):
        edited("a: &x one\nb: *x\n", ("a",), "two", "a.yaml")


@pytest.mark.parametrize(
    ("text", "value"), [("1_000", 1000), ("0x1F", 31), ("0.5", 0.5), ("0", 0), ("'017'", "017"), ("1:30 h", "1:30 h")]
)
def test_numbers_that_people_mean_are_read(tmp_path: Path, text: str, value: object):
    (tmp_path / "a.yaml").write_text(f"a: {text}\n")
    assert load(tmp_path / "a.yaml").need("a").value == value


@pytest.mark.parametrize(
    ("text", "value"), [("1:30", "90"), ("017", "15"), ("190:20:30", "685230"), ("1:30.5", "90.5")]
)
def test_a_number_of_another_base_is_refused_with_what_it_is(tmp_path: Path, text: str, value: str):
    (tmp_path / "a.yaml").write_text(f"a: {text}\n")
    with pytest.raises(InputError, match=rf"a\.yaml:1: a={text} must .* takes it for {value}; write {value}"):
        load(tmp_path / "a.yaml")
