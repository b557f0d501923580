"""CITATION.cff is a file of format 1.2.0 that names this version, and the paper."""

from __future__ import annotations

import re
from pathlib import Path

import yaml

import scaloft_fi

TOLD = yaml.safe_load((Path(__file__).resolve().parents[2] / "CITATION.cff").read_text())
NEEDED = {"cff-version", "message", "title", "authors"}
USED = NEEDED | {"type", "abstract", "version", "license", "keywords", "references"}
"""Keys of the format: those that every file has, and those of this one."""


def test_it_has_what_the_format_needs() -> None:
    assert TOLD["cff-version"] == "1.2.0"
    assert NEEDED < set(TOLD) == USED
    assert TOLD["type"] in ("software", "dataset")
    for entry in (TOLD, *TOLD["references"]):
        assert entry["title"]
        assert entry["authors"]
        assert all("name" in author or {"family-names", "given-names"} <= set(author) for author in entry["authors"])


def test_it_names_this_version() -> None:
    assert TOLD["version"] == scaloft_fi.__version__


def test_it_names_the_paper_and_who_wrote_it() -> None:
    (paper,) = TOLD["references"]
    assert paper["title"].startswith("SCALOFT: ")
    assert [author["family-names"] for author in paper["authors"]] == ["Proma", "Hodge", "Alexander"]
    assert all(
        re.fullmatch(r"https://orcid\.org/(\d{4}-){3}\d{3}[\dX]", author["orcid"]) for author in paper["authors"]
    )
