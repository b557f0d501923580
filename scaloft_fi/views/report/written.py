"""What `report` says of the page that it wrote."""

from __future__ import annotations

from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.shape import count, text
from scaloft_fi.views.stale import KEYS as STALE

REPORT = Output(
    "report",
    "1.1",
    "where the report was written",
    {"report": text("path of the page"), "bytes": count("its size [bytes]"), **STALE},
    rows="summary",
)
