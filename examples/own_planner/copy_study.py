"""Write a study for `straight`: the reference study, in which `sim/stack.yaml` names this stack.

python copy_study.py FOLDER
"""

import shutil
import sys
from pathlib import Path

from scaloft_fi.study import Study


def copy_study(folder: Path, source: Path | None = None) -> None:
    """Copy the study in `source`, else the nearest or packaged one, and name the stack."""
    study = Study.open(source).folder
    for name in ("hazop", "mutants", "sim"):
        shutil.copytree(study / name, folder / name)
    settings = folder / "sim" / "stack.yaml"
    settings.write_text(settings.read_text().replace("name: reference", "name: straight"))


if __name__ == "__main__":
    copy_study(Path(sys.argv[1]))
