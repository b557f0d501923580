"""The reference page of YAML keys has every key of every schema."""

from __future__ import annotations

import json
import re

from schemas import keys_of

from scaloft_fi.reference import yaml_keys_page
from scaloft_fi.verbs.schema import DOCUMENTS, declared_names


def test_every_document_and_every_key_is_on_the_page() -> None:
    page = yaml_keys_page()
    sections = dict(re.findall(r"^## `(.*?)`\n(.*?)(?=^## |\Z)", page, re.MULTILINE | re.DOTALL))
    names = declared_names(own=True)
    for one in DOCUMENTS.values():
        told = re.findall(r"^\| `(.*?)` \|", sections[one.files], re.MULTILINE)
        keys = {pointer[-1] for pointer in keys_of(one.schema(names)) if "then" not in pointer}
        assert {re.sub(r"\[\]|\?", "", name).rpartition(".")[2] for name in told} - {"*"} == keys, one.name


def test_a_row_has_type_range_default_and_example() -> None:
    page = yaml_keys_page()
    assert (
        "| `light` | number from 0 to 1 | brightness of visible light: 0 dark, 1 full  Such as `0.9`, `0.003`. |"
        in page
    )
    assert (
        "| `mine.scale_m?` | number above 0; left out: 1 | metres per unit of the file \\[m\\]  Such as `0.01`. |"
        in page
    )
    assert "| `name` | reference |" in page


def test_the_settings_for_an_editor_are_json_and_name_every_document() -> None:
    settings = json.loads(re.search(r"```json\n(.*?)```", yaml_keys_page(), re.DOTALL)[1])  # type: ignore[index]
    assert set(settings["yaml.schemas"].values()) == {one.files for one in DOCUMENTS.values()}
