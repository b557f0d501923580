"""Write the published JSON Schemas, from what the code declares: of what verbs print, and of the documents of a study.

python docs/schemas/write.py
"""

from __future__ import annotations

from pathlib import Path

from scaloft_fi.verbs.schema import answer_texts, declared_names, schema_texts

HERE = Path(__file__).parent


def main() -> None:
    """Write a file for each verb and each document, and remove those of verbs and documents that are no more."""
    for folder, texts in (("output", answer_texts()), ("study", schema_texts(declared_names(own=True)))):
        (HERE / folder).mkdir(exist_ok=True)
        for path in (HERE / folder).glob("*.json"):
            if path.name not in texts:
                path.unlink()
        for name, text in texts.items():
            (HERE / folder / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
