"""Bad inputs recorded from every key of every document: no refusal tells less than its record."""

from __future__ import annotations

from pathlib import Path

import pytest
from effort import usually
from every_key import every_key_study
from refusals import bad_inputs, recorded, told

EVERY = usually(12, release=1)


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return every_key_study(tmp_path_factory.mktemp("every_key") / "study")


def test_each_bad_input_is_refused_as_the_record_says(study: Path) -> None:
    record = recorded()
    bad = [one for one in bad_inputs(study) if one.name in record]
    assert len(bad) == len(record) >= 300, "the record is made by python tests/support/refusals.py"
    said = {one.name: told(study, one) for one in bad[::EVERY]}
    assert said == {name: record[name] for name in said}
