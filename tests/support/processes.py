"""Other processes: what runs here, packages of other authors, wheels and environments to install them in."""

from __future__ import annotations

import json
import os
import shutil
import site
import sqlite3
import subprocess
import sys
import sysconfig
import time
import tomllib
import venv
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
GROUP = "scaloft_fi.plugins"


def alive(process: int) -> bool:
    """Whether a process runs; what has ended may wait for its parent."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def marked(mark: str) -> list[int]:
    """The living processes with `MARK=mark` in their environment."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            environment = (path / "environ").read_bytes() if alive(int(path.name)) else b""
        except OSError:
            continue
        if f"MARK={mark}\0".encode() in environment:
            found.append(int(path.name))
    return found


def soon(true: Callable[[], bool], within_s: float = 30.0) -> bool:
    """Whether something becomes true."""
    due_s = time.monotonic() + within_s
    while not (is_true := true()) and time.monotonic() < due_s:
        time.sleep(0.02)
    return is_true


def saved(store: Path) -> int:
    """Number of outcomes in a store; 0 before it is there."""
    try:
        with closing(sqlite3.connect(f"{store.absolute().as_uri()}?mode=ro", uri=True)) as connection:
            return int(connection.execute("SELECT count(*) FROM outcomes").fetchone()[0])
    except sqlite3.OperationalError:
        return 0


def install(site: Path, package: str, entries: Mapping[str, str]) -> None:
    """Write what `importlib.metadata` reads of an installed package: its name, and its entry points."""
    info = site / f"{package}-1.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Name: {package}\nVersion: 1\n")
    lines = [f"{name} = {module}" for name, module in entries.items()]
    (info / "entry_points.txt").write_text("\n".join([f"[{GROUP}]", *lines, ""]))


def install_project(site: Path, project: Path) -> None:
    """Install a project's folder as it stands: its packages by path, its entry points from its `pyproject.toml`."""
    declared = tomllib.loads((project / "pyproject.toml").read_text())["project"]
    install(site, declared["name"], declared["entry-points"][GROUP])
    for package in project.glob("*/__init__.py"):
        (site / package.parent.name).symlink_to(package.parent, target_is_directory=True)


def call(site: Path, *words: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Python with these words, in a process that sees the packages of `site`."""
    path = os.pathsep.join([str(site), str(ROOT), *filter(None, sys.path)])
    environment = os.environ | {"PYTHONPATH": path}
    command = [sys.executable, *map(str, words)]
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)


def printed(*words: str | Path, site: Path = ROOT, cwd: Path = ROOT) -> str:
    """What Python with these words prints, as `call` has it; it must succeed."""
    done = call(site, *words, cwd=cwd)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


_RUNNER = """
import contextlib, io, json, sys
from scaloft_fi.cli import main

told = []
for words in json.loads(sys.argv[1]):
    printed = io.TextIOWrapper(io.BytesIO(), write_through=True)
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
        try:
            main.main(words)
        except SystemExit as ended:
            told.append([ended.code, printed.buffer.getvalue().decode()])
print("told", json.dumps(told))
"""


def called(site: Path, *verbs: Sequence[str], cwd: Path) -> list[tuple[int, str]]:
    """Exit code and output of each verb, called one after another in one process that sees the packages of `site`."""
    done = call(site, "-c", _RUNNER, json.dumps(verbs), cwd=cwd)
    last = next((line for line in done.stdout.splitlines() if line.startswith("told ")), None)
    assert last, done.stdout + done.stderr
    return [(code, printed) for code, printed in json.loads(last.removeprefix("told "))]


def shell(*words: str | Path, cwd: Path) -> str:
    """What a command prints; it must succeed."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "PIP_TARGET"))}
    done = subprocess.run(list(map(str, words)), cwd=cwd, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def checkout_in(folder: Path) -> Path:
    """The files that a clone would hold, as far as a build reads them."""
    folder.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE", ".gitignore"):
        shutil.copy(ROOT / name, folder / name)
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())
    included = declared["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    for name in ("scaloft_fi", *included):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def built(checkout: Path, folder: Path) -> Path:
    """The wheel of a checkout, in `folder`."""
    shell(sys.executable, "-m", "build", "--wheel", "--outdir", folder, checkout, cwd=folder)
    (wheel,) = folder.glob("*.whl")
    return wheel


def wheel_of(folder: Path) -> Path:
    """The wheel of this checkout, in `folder`."""
    return built(checkout_in(folder / "checkout"), folder)


def fresh(folder: Path) -> Path:
    """A new environment that sees the installed dependencies, but no editable install of ours; returns its python."""
    venv.create(folder, with_pip=False, symlinks=True)
    (_site(folder) / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return folder / "bin" / "python"


def pip_install(python: Path, *what: str | Path, cwd: Path | None = None) -> None:
    """Install a wheel or a folder into an environment, without its dependencies."""
    words = ("-m", "pip", "--python", python, "install", "--quiet", "--no-deps", *what)
    shell(sys.executable, *words, cwd=cwd or python.parent)


def lend_kernels(python: Path) -> None:
    """Lend the compiled kernels of this checkout to an installed wheel of the same sources.

    numba takes machine code for that of a source with the same name, size and time of change; so the time is lent too.
    """
    installed = _site(python.parents[1]) / "scaloft_fi"
    for kernels in ROOT.joinpath("scaloft_fi").rglob("__pycache__/*.nb[ic]"):
        source = kernels.parents[1] / f"{kernels.name.partition('.')[0]}.py"
        target = installed / source.relative_to(ROOT / "scaloft_fi")
        if source.is_file() and target.is_file() and source.read_bytes() == target.read_bytes():
            (target.parent / "__pycache__").mkdir(exist_ok=True)
            shutil.copy(kernels, target.parent / "__pycache__" / kernels.name)
            status = source.stat()
            os.utime(target, ns=(status.st_atime_ns, status.st_mtime_ns))


def _site(environment: Path) -> Path:
    return next(environment.glob("lib/python*/site-packages"))


PIP = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet"]
QUICKLY = ["--retries", "0", "--timeout", "10"]
LIMIT_S = 120.0


def python_with_ros2(folder: Path) -> tuple[str, str]:
    """Its path, and why there is none."""
    wanted = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]["ros2"]
    try:
        report = _run([*PIP, "install", *QUICKLY, "--dry-run", "--report", "-", "--prefer-binary", *wanted])
        names = [f"{one['metadata']['name']}=={one['metadata']['version']}" for one in json.loads(report)["install"]]
        if not names:
            return sys.executable, ""
        _run([sys.executable, "-m", "venv", "--without-pip", str(folder)])
        python = folder / "bin" / "python"
        packages = folder / "lib" / f"python{sysconfig.get_python_version()}" / "site-packages"
        (packages / "tests.pth").write_text("\n".join([*site.getsitepackages(), str(ROOT)]) + "\n")
        _run([*PIP, "--python", str(python), "install", *QUICKLY, "--no-deps", *names])
        _run([str(python), "-c", "import rclpy, nav_msgs.msg"])
    except (subprocess.SubprocessError, OSError) as error:
        said = getattr(error, "stderr", "") or str(error)
        return (
            "",
            f"the wheels of ROS 2 cannot be installed here, so the border ros2 is not tested: {said.strip()[-300:]}",
        )
    return str(python), ""


def _run(words: list[str]) -> str:
    return subprocess.run(words, check=True, capture_output=True, text=True, timeout=LIMIT_S).stdout
