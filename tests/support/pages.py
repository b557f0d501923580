"""The page of a report as its readers take it: a browser, a script, somebody who counts the flights again."""

from __future__ import annotations

import base64
import json
import re
import struct
import zlib
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import recomputation

from scaloft_fi.verbs.export.dossier import export_rows, to_json
from scaloft_fi.verbs.report.analyses import Evidence

OPEN = {"flight": "#sheet .map", "mutant": "#sheet .sheet-body", "cell": "#sheet .mutant"}
"""What shows that a sheet is open, by its kind."""

BEHIND = "Rendering was performed in a subtree hidden by content-visibility."
"""What Chromium says where somebody, as axe-core, measures what is behind a sheet."""


class Visit:
    """One page opened from disk; remembers what the console said and what was asked of a network."""

    def __init__(self, browser: Any, path: Path, fragment: str = "", *, whole: bool = True, **context: Any) -> None:
        self.context = browser.new_context(**{"viewport": {"width": 1280, "height": 900}, **context})
        self.page = self.context.new_page()
        self.said: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", lambda message: message.text.startswith(BEHIND) or self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(path.as_uri() + fragment)
        self.page.wait_for_selector("#glossary")
        if whole:
            self.page.evaluate(
                "() => document.querySelectorAll('details.whole').forEach((one) => { one.open = true; })"
            )
            self.page.wait_for_function("document.querySelector('#kills td.state') !== null")
        if fragment:
            self.page.wait_for_selector(OPEN[fragment[1:].partition("=")[0]])

    def hash(self) -> str:
        return str(self.page.evaluate("location.hash"))

    def close(self) -> None:
        self.context.close()
        assert self.said == []
        assert [url for url in self.asked if not url.startswith(("file:", "data:"))] == []
        assert len([url for url in self.asked if url.startswith("file:")]) == 1


Opened = Callable[..., Visit]


def embedded(text: str, name: str) -> Any:
    """The JSON of a script element by its id; that of the figures is deflated."""
    found = re.findall(rf'<script type="application/json" id="{name}">(.*?)</script>', text, re.DOTALL)
    assert len(found) == 1
    told = json.loads(found[0])
    return json.loads(zlib.decompress(base64.b64decode(told))) if name == "figures" else told


def unpacked(pack: str, quanta: list[float]) -> list[dict[str, Any]]:
    """The flights of a pack, each with its rows as whole numbers times the quantum."""
    data = zlib.decompress(base64.b64decode(pack))
    (length,) = struct.unpack_from("<I", data)
    told = json.loads(data[4 : 4 + length])
    at = 4 + length
    tracks: list[list[list[int]]] = []
    for count, same, base in told["tracks"]:
        own = count - same
        size = own * len(quanta)
        low, high = data[at : at + size], data[at + size : at + 2 * size]
        at += 2 * size
        rows = [list(row) for row in tracks[base][:same]] if same else []
        fresh = [[0] * len(quanta) for _ in range(own)]
        for column in range(len(quanta)):
            value = rows[-1][column] if rows else 0
            for row in range(own):
                word = low[column * own + row] + 256 * high[column * own + row]
                value += word // 2 if word % 2 == 0 else -(word + 1) // 2
                value = (value + 32768) % 65536 - 32768
                fresh[row][column] = value
        tracks.append(rows + fresh)
    assert at == len(data)
    return [
        flight | {"rows": None if flight["track"] is None else _scaled(tracks[flight["track"]], quanta)}
        for flight in told["flights"]
    ]


def _scaled(rows: list[list[int]], quanta: list[float]) -> list[list[float]]:
    return [[value * quantum for value, quantum in zip(row, quanta, strict=True)] for row in rows]


Row = dict[str, Any]
SAFETY = ("SR1", "SR2")
CLEAN = ("baseline", "PLACEBO")


def exported(evidence: Evidence) -> list[Row]:
    """The rows of `export --format json`."""
    study = evidence.study
    return json.loads(to_json(export_rows(evidence.outcomes, study.roster, study.space)))


def states_of(rows: list[Row]) -> dict[tuple[str, str], str]:
    """The state of each pair of situation and requirement."""
    pool = [row | {"counts": row["status"] != "invalid"} for row in rows if row["mutant"] == "baseline"]
    found = recomputation.pairs(pool, {**dict.fromkeys(SAFETY, "safety"), "OP1": "operability"})
    return {(pair["situation"], pair["requirement"]): pair["state"] for pair in found}


@dataclass
class Count:
    """A mutant in a situation: flights that count, whether any is infected, flights that violate each requirement."""

    flown: int = 0
    infected: bool = False
    violated: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    statuses: set[str] = field(default_factory=set)
    tests: tuple[str, ...] = ()

    @property
    def most(self) -> list[str]:
        """The safety requirements that test the mutant here and that most flights violate."""
        return [name for name in self.tests if self.violated[name] > self.flown / 2]


def counts_of(rows: list[Row]) -> dict[str, dict[str, Count]]:
    """By mutant and situation."""
    states = states_of(rows)
    found: dict[str, dict[str, Count]] = defaultdict(lambda: defaultdict(Count))
    for row in rows:
        if row["mutant"] in CLEAN:
            continue
        count = found[row["mutant"]][row["situation"]]
        if row["status"] == "invalid":
            continue
        count.flown += 1
        count.infected |= row["infected_at_s"] is not None
        count.statuses.add(row["status"])
        for name in row["violated"]:
            count.violated[name] += 1
    for by_situation in found.values():
        for key, count in by_situation.items():
            count.tests = tuple(name for name in SAFETY if count.infected and states.get((key, name)) == "steady")
    return found
