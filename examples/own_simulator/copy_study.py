"""Write a study whose flights a command flies: the reference study, with `sim/flyer.yaml` and `sim/record.yaml`.

python copy_study.py FOLDER [study_bag]

With `study_bag` the program records as a simulator of ROS 2 does, in a folder of rosbag2.
"""

import shutil
import sys
from pathlib import Path

from scaloft_fi.study import Study

HERE = Path(__file__).resolve().parent
PARTS = ("hazop", "mutants", "sim")


def copy_study(folder: Path, source: Path | None = None, kind: str = "study") -> None:
    """Copy the study in `source`, else the nearest or packaged one; `world/` is what the program knows of it."""
    study = Study.open(source).folder
    for name in PARTS:
        shutil.copytree(study / name, folder / name)
        shutil.copytree(study / name, folder / "world" / name)
    shutil.copytree(HERE / kind / "sim", folder / "sim", dirs_exist_ok=True)
    for program in ("fly.py", "bag.py"):
        shutil.copy(HERE / program, folder)


if __name__ == "__main__":
    copy_study(Path(sys.argv[1]), kind=sys.argv[2] if len(sys.argv) > 2 else "study")
