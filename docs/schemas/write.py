"""Write the published JSON Schemas of what verbs print, from what the code declares.

python docs/schemas/write.py
"""

from __future__ import annotations

from pathlib import Path

from scaloft_fi.views.outputs.listed import schema_texts

FOLDER = Path(__file__).parent / "output"


def main() -> None:
    """Write a file for each verb, and remove those of verbs that have none."""
    texts = schema_texts()
    for path in FOLDER.glob("*.json"):
        if path.name not in texts:
            path.unlink()
    for name, text in texts.items():
        (FOLDER / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
