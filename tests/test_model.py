"""Models of documents and what is read into them."""

from __future__ import annotations

import errno
import os
import pickle
import socket
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from options import usually
from studies import build, item_of

from scaloft_fi import document, marks
from scaloft_fi.document import Item, UnreadableError, digest, read_bytes, read_text
from scaloft_fi.errors import FaultsError, InputError
from scaloft_fi.model import read, schema


class Point(NamedTuple):
    x_m: float
    y_m: float = 2.0


@dataclass(frozen=True)
class Inner:
    """An inner thing.

    Attributes:
        name: what it is called.
    """

    id: marks.Key
    name: str
    size_m: float = 1.0
    place: marks.Place = ""

    def contradictions(self, item: Item) -> Iterator[InputError]:
        if self.size_m == 13:
            yield item.need("size_m").error("another number")


@dataclass(frozen=True)
class Round:
    shape: Literal["round"]
    radius_m: marks.Positive


@dataclass(frozen=True)
class Flat:
    shape: Literal["flat"]
    edges_m: tuple[marks.Positive, Annotated[float, marks.Bounds(most=1e12)]]


@dataclass(frozen=True)
class Near:
    at_s: float


@dataclass(frozen=True)
class Far:
    topic: str
    place: int = 0


@dataclass(frozen=True)
class Outer:
    parts: Annotated[tuple[Inner, ...], marks.ByName(), marks.Pattern("[a-z]+", "small letters")]
    count: marks.Count
    share: marks.Share
    words: Annotated[tuple[str, ...], marks.Size(1, 3)]
    shape: Annotated[Round | Flat, marks.Either(by="shape")]
    stands: Annotated[Near | Far, marks.Either("{at_s: NUMBER} or {topic: NAME}")]
    kind: Annotated[str, marks.Choices({"a": "the first", "b": "the second"})] = "a"
    seam: Annotated[str, marks.Choices(named="seams")] = ""
    from_: Annotated[float | None, marks.Called("from")] = None
    quality: Mapping[str, marks.Scalar] = field(default_factory=dict)
    point: Point = field(default_factory=lambda: Point(1.0))
    rest: Mapping[str, Any] = field(default_factory=dict)


GOOD: dict[str, Any] = {
    "parts": {"left": {"name": "a"}, "right": {"name": "b", "size_m": 2}},
    "count": 3,
    "share": 0.5,
    "words": ["x"],
    "shape": {"shape": "flat", "edges_m": [1, 1e12]},
    "stands": {"topic": "/a"},
    "from": 4,
    "quality": {"depth": 1, "kind": "x", "on": True},
    "rest": {"a": {"b": [1, 2]}},
}


def told(**changes: Any) -> list[str]:
    """What is said of the good values with these changed; a change to None leaves the key out."""
    values = {key: value for key, value in {**GOOD, **changes}.items() if value is not None}
    with pytest.raises(InputError) as refused:
        build(Outer, values)
    error = refused.value
    return [str(one) for one in (error.faults if isinstance(error, FaultsError) else [error])]


def test_every_kind_of_field_is_read():
    outer = build(Outer, GOOD)
    assert outer.parts == (Inner("left", "a", 1.0, "s.yaml:1"), Inner("right", "b", 2.0, "s.yaml:1"))
    assert (outer.shape, outer.stands) == (Flat("flat", (1.0, 1e12)), Far("/a"))
    assert (outer.kind, outer.from_, outer.point, outer.rest) == ("a", 4.0, Point(1.0), GOOD["rest"])


@pytest.mark.parametrize(
    ("changes", "facts"),
    [
        ({"cuont": 3, "count": None}, ["s.yaml:1", "'cuont'", "did you mean 'count'"]),
        ({"count": None}, ["stack lacks the key 'count'"]),
        ({"count": 0}, ["count=0", ">= 1"]),
        ({"count": 1001}, ["count=1001", "<= 1000"]),
        ({"share": True}, ["share=True", "a number"]),
        ({"share": float("nan")}, ["share=nan", "a number"]),
        ({"words": []}, ["at least one"]),
        ({"words": "x"}, ["words='x'", "a list"]),
        ({"words": ["x"] * 4}, ["at most 3"]),
        ({"parts": {"Left": {"name": "a"}}}, ["'Left'", "small letters"]),
        ({"parts": {"left": {"sise_m": 2, "name": "a"}}}, ["'sise_m' in left", "did you mean 'size_m'"]),
        ({"parts": {"left": {"name": "a", "size_m": 13}}}, ["size_m=13", "another number"]),
        ({"parts": {"left": {}}}, ["left lacks the key 'name': what it is called"]),
        ({"kind": "c"}, ["kind='c'", "'a', 'b'"]),
        ({"shape": {"shape": "rouund", "radius_m": 1}}, ["shape='rouund'", "did you mean 'round'"]),
        ({"shape": {"shape": "flat", "edges_m": [1]}}, ["edges_m=[...]", "a list of 2 numbers"]),
        ({"shape": {"shape": "round", "edges_m": [1, 1]}}, ["lacks the key 'radius_m'"]),
        ({"stands": {"at_s": 1, "topic": "/a"}}, ["{at_s: NUMBER} or {topic: NAME}"]),
        ({"stands": {"place": 1}}, ["stands lacks the key 'topic'"]),
        ({"quality": {"depth": [1]}}, ["depth=[...]", "a text or a number or true or false"]),
        ({"from": "x"}, ["from='x'", "a number"]),
        ({"point": 3}, ["point=3", "a mapping"]),
    ],
)
def test_a_fault_is_told_with_place_name_value_and_what_is_allowed(changes: dict[str, Any], facts: list[str]):
    first = told(**changes)[0]
    assert all(fact in first for fact in ["s.yaml:1", *facts]), first


def test_one_reading_tells_every_fault():
    parts = {"left": {"name": 3, "sise_m": 2}, "right": {"size_m": "x"}}
    faults = told(parts=parts, count=0, cuont=1, share=None, words=["", "x"])
    assert len(faults) == 8
    assert len({*faults}) == len(faults)


def test_names_of_the_study_are_held_against_what_is_handed_over():
    assert read(Outer, item_of(GOOD | {"seam": "pose"}), {"seams": ["pose"]}).seam == "pose"
    assert build(Outer, GOOD | {"seam": "any"}).seam == "any"
    with pytest.raises(InputError, match="did you mean 'pose'"):
        read(Outer, item_of(GOOD | {"seam": "poze"}), {"seams": ["pose"]})


_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-2, 1200) | st.floats(-3, 3) | st.sampled_from(["", "a", "x", "left"]),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from([*GOOD, "left", "name"]), inner, max_size=3)
    ),
    max_leaves=6,
)


@given(st.sampled_from([*GOOD, "kind", "point", "seam"]), _VALUES)
@settings(max_examples=usually(200, release=2_000))
def test_a_value_is_read_if_and_only_if_the_schema_allows_it(key: str, value: Any):
    """Contradictions apart, and but for texts of white space, of which a schema knows nothing."""
    values = GOOD | {key: value}
    valid = Draft202012Validator(schema(Outer)).is_valid(values)
    try:
        build(Outer, values)
    except InputError:
        assert not valid
    else:
        assert valid


def pipe(path: Path) -> None:
    os.mkfifo(path)


def listening(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as plug:
        plug.bind(str(path))


ODD = {
    "a pipe": pipe,
    "a folder": Path.mkdir,
    "a device": lambda path: path.symlink_to("/dev/zero"),
    os.strerror(errno.ELOOP): lambda path: path.symlink_to(path.name),
    os.strerror(errno.ENOENT): lambda path: path.symlink_to("nowhere"),
    os.strerror(errno.ENXIO): listening,
}


@pytest.mark.parametrize("read", [read_bytes, read_text, digest])
@pytest.mark.parametrize("kind", ODD)
def test_what_is_no_regular_file_is_refused_at_once(tmp_path, monkeypatch, kind, read):
    monkeypatch.chdir(tmp_path)  # a socket has a short name
    ODD[kind](path := Path("odd"))
    with pytest.raises(UnreadableError, match=f"^odd: cannot be read: .*{kind}"):
        read(path)


@pytest.mark.parametrize("name", ["a\0b", "a" * 300, "~nosuchuser/a.yaml", "nowhere/a.yaml"])
def test_a_name_that_the_system_refuses_is_refused_in_a_sentence(tmp_path, name):
    with pytest.raises(UnreadableError, match="cannot be read: "):
        read_bytes(tmp_path / name)
    assert not document.is_file(tmp_path / name)
    assert not document.is_folder(tmp_path / name)


def test_a_file_of_the_largest_size_is_read_and_a_larger_file_is_refused_with_the_limit(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(b"x" * 1000)
    assert read_bytes(path, 1000) == b"x" * 1000
    assert digest(path, 1000) == digest(path)
    for reader in (read_bytes, read_text, digest):
        with pytest.raises(UnreadableError, match="larger than 999 bytes"):
            reader(path, 999)


def test_a_file_whose_size_the_system_does_not_tell_is_bounded_too(monkeypatch):
    status = Path("/proc/self/status")
    if not status.exists():
        pytest.skip("only Linux has files of unknown size")
    assert status.stat().st_size == 0
    with pytest.raises(UnreadableError, match="larger than 10 bytes"):
        read_bytes(status, 10)


def test_bytes_that_are_no_text_are_refused(tmp_path):
    (tmp_path / "a").write_bytes(b"\xff")
    with pytest.raises(UnreadableError, match="not UTF-8 text"):
        read_text(tmp_path / "a")


def test_a_link_that_leads_nowhere_is_there(tmp_path):
    (tmp_path / "a").symlink_to("nowhere")
    assert document.is_there(tmp_path / "a")
    assert not document.is_there(tmp_path / "b")


def test_the_refusal_survives_the_way_between_processes(tmp_path):
    with pytest.raises(UnreadableError) as error:
        read_bytes(tmp_path / "a")
    again = pickle.loads(pickle.dumps(error.value))
    assert (str(again), again.reason) == (str(error.value), os.strerror(errno.ENOENT))
