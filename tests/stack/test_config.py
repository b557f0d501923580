from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import pytest

from scaloft_fi.stack.config import ConfigError, Scalar, build


class Point(NamedTuple):
    x_m: float
    y_m: float = 2.0


@dataclass(frozen=True)
class Inner:
    name: str
    size_m: float = 1.0


@dataclass(frozen=True)
class Outer:
    parts: Mapping[str, Inner]
    quality: Mapping[str, Scalar] = field(default_factory=dict)
    point: Point = field(default_factory=lambda: Point(1.0))
    rest: Mapping[str, Any] = field(default_factory=dict)


def test_a_field_with_a_default_may_be_left_out():
    assert build(Inner, {"name": "a"}) == Inner("a", 1.0)
    assert build(Point, {"x_m": 3}) == Point(3.0, 2.0)
    with pytest.raises(ConfigError, match="stack: lacks the setting 'name'"):
        build(Inner, {"size_m": 2.0})


def test_a_mapping_takes_any_keys_and_checks_each_value():
    built = build(Outer, {"parts": {"left": {"name": "a"}, "right": {"name": "b", "size_m": 2}}})
    assert built.parts == {"left": Inner("a"), "right": Inner("b", 2.0)}
    with pytest.raises(ConfigError) as refused:
        build(Outer, {"parts": {"left": {"name": "a", "sise_m": 2}}})
    assert refused.value.path == "stack.parts.left.sise_m"
    assert "did you mean 'size_m'" in str(refused.value)
    with pytest.raises(ConfigError, match=r"stack\.parts: must be a mapping"):
        build(Outer, {"parts": ["left"]})


def test_a_mapping_of_scalars_takes_texts_numbers_and_flags_only():
    assert build(Outer, {"parts": {}, "quality": {"depth": 1, "kind": "x", "on": True}}).quality["depth"] == 1
    with pytest.raises(ConfigError, match=r"stack\.quality\.depth: must be a text, a number, true or false"):
        build(Outer, {"parts": {}, "quality": {"depth": [1]}})


def test_settings_of_another_schema_are_handed_over_as_they_are():
    assert build(Outer, {"parts": {}, "rest": {"a": {"b": [1, 2]}}}).rest == {"a": {"b": [1, 2]}}
