"""What `report` says of the page that it wrote."""

from __future__ import annotations

from scaloft_fi.views.outputs.output import Output
from scaloft_fi.views.outputs.shape import count, text

REPORT = Output(
    "report",
    "1.0",
    "where the report was written",
    {"report": text("path of the page"), "bytes": count("its size [bytes]")},
    rows="summary",
)
