"""A Python with ROS 2: the wheels of the extra `ros2` beside all that the running Python has."""

from __future__ import annotations

import json
import site
import subprocess
import sys
import sysconfig
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
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
