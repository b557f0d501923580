"""YAML with places: what the safe loader gives, and what is refused in one sentence."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from scaloft_fi.document import ITEMS, load
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
        ("a: &x [*x]\n", "a.yaml:1: a[0] contains itself"),
        ("? [1, 2]\n: 3\n", "a.yaml:1: a key of a.yaml must be a single word"),
        (b"\xff\xfe\x00", "cannot be read: not UTF-8 text"),
    ],
)
def test_what_cannot_be_read_is_refused_with_its_line(read, text, sentence):
    with pytest.raises(InputError) as error:
        read(text)
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("ask", "sentence"),
    [
        (lambda d: d.need("radius").number(), "a.yaml:1: radius='wide' must be a number"),
        (lambda d: d.need("size").number(above=0.0), "a.yaml:2: size=-2 must be > 0"),
        (lambda d: d.need("size").number(least=0.0, most=1.0), "a.yaml:2: size=-2 must be >= 0 and <= 1"),
        (lambda d: d.need("size").flag(), "a.yaml:2: size=-2 must be true or false"),
        (lambda d: d.need("size").text(), "a.yaml:2: size=-2 must be a text"),
        (lambda d: d.need("size").items(), "a.yaml:2: size=-2 must be a list"),
        (lambda d: d.need("on").number(), "a.yaml:4: on=True must be a number"),
        (lambda d: d.need("place").text(), "a.yaml:3: place=[...] must be a text"),
        (
            lambda d: d.need("radius").choice(["width", "depth"]),
            "a.yaml:1: radius='wide' is not known; did you mean 'width'?",
        ),
        (lambda d: d.need("height"), "a.yaml:1: a.yaml lacks the key 'height'"),
        (lambda d: d.need("raduis"), "a.yaml:1: unknown key 'radius' in a.yaml; did you mean 'raduis'?"),
    ],
)
def test_a_value_that_does_not_fit_is_named_with_what_is_allowed(read, ask, sentence):
    document = read("radius: wide\nsize: -2\nplace: [1, 2]\non: true\n")
    with pytest.raises(InputError) as error:
        ask(document)
    assert sentence in str(error.value)


def test_keys_that_nobody_asked_for_are_refused_with_the_nearest_known_one(read):
    document = read("radius: 1\nhieght: 2\n")
    document.get("radius")
    document.get("height")
    with pytest.raises(InputError, match=r"a.yaml:2: unknown key 'hieght' in a.yaml; did you mean 'height'\?"):
        document.close()


def test_not_a_number_is_no_number(read):
    with pytest.raises(InputError, match="must be a number"):
        read("a: .nan\n").need("a").number()


def test_a_date_that_is_none_is_refused_with_its_place(read):
    with pytest.raises(InputError, match=r"a\.yaml:2: day='2027-02-30' cannot be read"):
        read("a: 1\nday: 2027-02-30\n")


def test_an_alias_stands_for_a_copy_that_knows_its_own_name_and_place(read):
    document = read("one: &a {b: [1, &c 2]}\ntwo: *a\nthree: *c\n")
    assert document.need("two").plain() == {"b": [1, 2]}
    assert (document.need("two").line, document.need("two").name) == (2, "two")
    assert document.need("three").number() == 2
    document.need("one").need("b")
    with pytest.raises(InputError, match="unknown key 'b' in two"):
        document.need("two").close()


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("a: *b\n", "a.yaml:1: alias 'b' has no anchor above it"),
        ("a: !!str 1\n", "a.yaml:1: a has the tag 'tag:yaml.org,2002:str'; write the value without a tag"),
        ("!x a: 1\n", "a key of a.yaml must be a single word"),
        ("a: 1\n---\nb: 1\n", "a.yaml:2: a second document must stand in a file of its own"),
        ("a:\n  b: " + "1" * 101, "a.yaml:2: b='1"),
        (
            "a: &a [1]\nb: [*a,\n *a]\nc: " + "[" * 50 + "*a" + "]" * 50,
            "a.yaml:4: the file must be nested at most 50",
        ),
    ],
)
def test_what_exceeds_a_limit_is_refused_with_its_line(read, text, sentence):
    with pytest.raises(InputError) as error:
        read(text)
    assert sentence in str(error.value)


def test_a_document_of_the_largest_depth_and_number_of_values_is_read(read):
    assert read("[" * 50 + "]" * 50).items()
    assert len(read(f"[{'1,' * (ITEMS - 1)}]").items()) == ITEMS - 1
    with pytest.raises(InputError, match="must have at most 30,000 values"):
        read(f"[{'1,' * ITEMS}]")


@pytest.mark.parametrize(
    ("ask", "sentence"),
    [
        (lambda d: d.plain(), "a.yaml:1: far=inf must be a finite number"),
        (lambda d: d.need("far").number(), "far=inf must be a finite number"),
        (lambda d: d.need("huge").number(), "huge=10000000000.0 must be >= -1e+09 and <= 1e+09"),
        (lambda d: d.need("huge").number(above=0.0), "huge=10000000000.0 must be > 0 and <= 1e+09"),
        (lambda d: d.need("many").whole(), "many=10000000000 must be a whole number >= 0 and <= 1000000000"),
        (lambda d: d.need("list").items(most=2), "list=[...] must be a list of at most 2 values"),
        (lambda d: d.mapping(most=2), "a.yaml={...} must be a mapping of at most 2 keys"),
    ],
)
def test_a_number_or_a_count_beyond_its_bounds_is_refused(read, ask, sentence):
    with pytest.raises(InputError) as error:
        ask(read("far: .inf\nhuge: 1.0e+10\nmany: 10000000000\nlist: [1, 2, 3]\n"))
    assert sentence in str(error.value)


def test_a_setting_may_allow_what_never_ends_or_is_larger(read):
    document = read("far: .inf\nhuge: 1.0e+10\n")
    assert document.need("far").number(infinite=True) == math.inf
    assert document.need("huge").number(most=1e12) == 1e10


def test_the_same_text_read_again_knows_no_key_yet_and_has_its_own_place(tmp_path: Path) -> None:
    first, second = tmp_path / "one" / "a.yaml", tmp_path / "two" / "a.yaml"
    for path in (first, second):
        path.parent.mkdir()
        path.write_text("size: {height: 1}\n")
    load(first).need("size").get("height")
    for path in (first, second):
        again = load(path)
        assert again.need("size").place == f"{path}:1"
        with pytest.raises(InputError, match="unknown key 'height'"):
            again.need("size").close()
