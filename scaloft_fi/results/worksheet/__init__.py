"""The HAZOP worksheet filled back: margins, dispositions, the sheet in many formats."""
