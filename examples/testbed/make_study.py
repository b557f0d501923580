"""Write a study whose mission is the scripts of the SCALOFT testbed, over ROS 1.

python make_study.py FOLDER SCRIPT...

The scripts are copied as they are and run one after the other; mine, vehicle, sensors and stack below them are those of
the reference study.
"""

import shutil
import sys
from pathlib import Path

from scaloft_fi.errors import InputError
from scaloft_fi.study import Study

HERE = Path(__file__).parent
SHARED = ("vehicle.yaml", "sensors.yaml")
ROUTE = ("route: [corner, home]", "route: [corner, end, corner, home]")
ARRIVAL = """
happenings:
  arrival:                 # the second script puts the person into the mine, when the drone is at the end
    kind: appear
    active: false
    body: person
    start: {near: [-3.0, 8.0], within_m: 0.3}
"""


def make_study(folder: Path, scripts: list[Path], source: Path | None = None) -> None:
    """Write the study; `source` has the mine, by default the nearest or packaged study."""
    for script in scripts:
        if not script.is_file():
            raise InputError(f"{script}: no such script")
    shutil.copytree(HERE / "study", folder)
    sim, shared = folder / "sim", Study.open(source).folder / "sim"
    for path in (*(shared / name for name in SHARED), HERE / "run_scripts.py", *scripts):
        shutil.copy(path, sim / path.name)
    world = (shared / "world.yaml").read_text()
    if world.count(ROUTE[0]) != 1:
        raise InputError(f"{shared / 'world.yaml'}: has no `{ROUTE[0]}`")
    (sim / "world.yaml").write_text(world.replace(*ROUTE) + ARRIVAL)
    names = ", ".join(f'"{{study}}/sim/{script.name}"' for script in scripts)
    inside = (shared / "stack.yaml").read_text().partition("name: reference")[2].partition("\n")[2]
    settings = sim / "stack.yaml"
    own = settings.read_text().replace("SCRIPTS", names)
    settings.write_text(own + "".join(f"  {line}\n" if line else "\n" for line in inside.splitlines()))


if __name__ == "__main__":
    try:
        make_study(Path(sys.argv[1]), [Path(name) for name in sys.argv[2:]])
    except InputError as error:
        sys.exit(f"make_study.py: {error}")
