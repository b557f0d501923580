"""Write a study whose planner runs in a process of its own: the mine and the situations of the reference study.

python make_study.py FOLDER [BORDER]

BORDER is `lines` (the default), `ros2`, or `inside`: the same planner in the process of the flight.
"""

import shutil
import sys
from pathlib import Path

from scaloft_fi.study import Study

HERE = Path(__file__).parent
SHARED = ("world.yaml", "vehicle.yaml", "sensors.yaml", "situations.yaml")
PROGRAMS = {"lines": "over_lines.py", "ros2": "over_ros2.py"}

DETERMINISTIC = "deterministic: true        # in lock step, and the planner draws no random numbers"


def make_study(folder: Path, border: str = "lines", source: Path | None = None) -> None:
    """Write the study; `source` has the mine and the situations, by default the nearest or packaged study."""
    shutil.copytree(HERE / "study", folder)
    for name in SHARED:
        shutil.copy(Study.open(source).folder / "sim" / name, folder / "sim" / name)
    for program in ("planner.py", *PROGRAMS.values()):
        shutil.copy(HERE / program, folder / "sim" / program)
    settings = folder / "sim" / "stack.yaml"
    text = settings.read_text()
    if border == "inside":
        text = text.replace("name: outside", "name: planner_inside")
    else:
        text = text.replace("border: lines", f"border: {border}").replace("over_lines.py", PROGRAMS[border])
    if border == "ros2":
        text = text.replace(DETERMINISTIC, "deterministic: false")
    settings.write_text(text)


if __name__ == "__main__":
    make_study(Path(sys.argv[1]), *sys.argv[2:])
