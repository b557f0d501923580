"""The page: figures and flights as data, style and script inlined, nothing fetched."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from scaloft_fi.console import all_printable
from scaloft_fi.views.report.evidence import Evidence
from scaloft_fi.views.report.figures import figures
from scaloft_fi.views.report.flights import DETAILS, columns, packs

MOST_BYTES = 5_000_000
"""The page fits into an e-mail."""
SAMPLE, HOPELESS = 8, 1.3
"""Every eighth situation is packed first; what it promises to exceed so far is not tried on all."""
STYLES = ("page.css", "matrices.css", "karnaugh.css", "flight.css")
SCRIPTS = (
    "dom.js",
    "text.js",
    "data.js",
    "glossary.js",
    "charts.js",
    "head.js",
    "hazop.js",
    "kills.js",
    "map.js",
    "player.js",
    "situation.js",
    "flight.js",
    "accepted.js",
    "karnaugh.js",
    "mutant.js",
    "margins.js",
    "cell.js",
    "follows.js",
    "found.js",
    "breaks.js",
    "sections.js",
    "paper.js",
    "main.js",
)
"""In the order in which they are joined; each is a part of one strict script."""


def page(evidence: Evidence, most_bytes: int = MOST_BYTES) -> str:
    """The whole report as the text of one HTML file, with as many tracks as fit into `most_bytes`.

    Raises:
        InputError: a part of the study is not what it should be.
    """
    content, outcomes = figures(evidence), evidence.outcomes
    names = [requirement.name for requirement in evidence.study.requirements]
    text = ""
    for detail in DETAILS:
        sample = sum(map(len, packs(outcomes, names, detail, SAMPLE).texts.values()))
        if detail is not DETAILS[-1] and sample * SAMPLE > HOPELESS * most_bytes:
            continue
        packed = packs(outcomes, names, detail)
        text = html(content | {"detail": packed.says, "columns": columns(detail)}, packed.texts)
        if len(text.encode()) <= most_bytes:
            break
    return text


def html(content: Mapping[str, Any], packed: Mapping[str, str]) -> str:
    """The page of these figures and packs of flights."""
    style = "\n".join(asset(name) for name in STYLES)
    script = '"use strict";\n(() => {\n' + "\n".join(asset(name) for name in SCRIPTS) + "\n})();\n"
    policy = (
        f"default-src 'none'; img-src data:; style-src '{_hash(style)}'; script-src '{_hash(script)}';"
        " base-uri 'none'; form-action 'none'"
    )
    parts = {
        "POLICY": policy,
        "STYLE": style,
        "FIGURES": inert(content),
        "FLIGHTS": inert(packed),
        "SCRIPT": script,
    }
    # in one pass, so that no part is searched for the places of others
    return re.sub(r"@([A-Z]+)@", lambda place: parts[place[1]], asset("page.html"))


def inert(values: Any) -> str:
    """JSON of printable texts that nothing in HTML can take for markup: no `<`, `>` or `&` is left in it."""
    text = json.dumps(all_printable(values), ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def asset(name: str) -> str:
    """The text of a file in `assets/`."""
    return files("scaloft_fi.views.report").joinpath("assets", name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    """A source expression of a Content Security Policy (W3C CSP level 3) that admits this text only."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
