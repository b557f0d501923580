from __future__ import annotations

from typing import Annotated, NamedTuple

import pytest

from scaloft_fi.stack.messages import (
    Array,
    Image,
    Point,
    Stamp,
    Vector,
    field_type,
    image_fields,
    number_fields,
    stamp_fields,
    vector_fields,
)


class Everything(NamedTuple):
    stamp_s: Stamp
    level: float
    count: int
    place: Point
    bare: Array
    push: Vector
    picture: Image
    pair: tuple[float, float]
    mixed: tuple[float, str]
    noted: Annotated[float, "a remark of the author"]
    flag: bool
    label: str


@pytest.mark.parametrize(
    ("of", "names"),
    [
        (stamp_fields, "stamp_s"),
        (vector_fields, "place push"),
        (image_fields, "picture"),
        (number_fields, "stamp_s level count place bare push picture pair noted"),
    ],
)
def test_the_kind_of_a_field_follows_from_its_annotation(of, names):
    assert of(Everything) == tuple(names.split())


def test_the_type_of_a_field_is_without_its_kind():
    assert field_type(Everything, "stamp_s") is float
    assert field_type(Everything, "place") == Point
