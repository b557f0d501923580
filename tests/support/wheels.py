"""The wheel of this checkout, and new environments that see the installed dependencies but no install of ours."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


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


def install(python: Path, *what: str | Path, cwd: Path | None = None) -> None:
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
