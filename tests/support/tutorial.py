"""Follows the tutorial: does its edits, runs its commands, and puts what they printed into the page.

`python tests/support/tutorial.py` does so in a new environment with the wheel, and writes `docs/tutorial.md` and its
pictures again.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from processes import ROOT, fresh, lend_kernels, pip_install, wheel_of

PAGE = ROOT / "docs" / "tutorial.md"
PICTURES = PAGE.with_suffix("")
BLOCK = re.compile(r"^```(\w+)(?: file=(\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PICTURE = re.compile(r"!\[[^]]*\]\(tutorial/([\w.]+)\)")
COMMANDS = re.compile(r"^\$ (.*)$", re.MULTILINE)


class Follower:
    """One user, in an empty folder, with an environment in which scaloft-fi is not installed yet.

    Args:
        folder: an empty folder.
        wheel: what `pip install scaloft-fi` installs.
    """

    def __init__(self, folder: Path, wheel: Path) -> None:
        self.folder = self.here = folder / "home"
        self.folder.mkdir()
        self._wheel, self._python = wheel, fresh(folder / "venv")

    def followed(self, page: str) -> str:
        """The page with what its commands print now.

        Raises:
            AssertionError: a command fails, or an edit does not fit its file.
        """
        return BLOCK.sub(lambda block: self._block(block[0], *block.groups()), page)

    def pictures(self, page: str) -> Mapping[str, bytes]:
        """The pictures of the page, by name."""
        return {name: next(self.folder.rglob(name)).read_bytes() for name in PICTURE.findall(page)}

    def _block(self, whole: str, language: str, name: str | None, text: str) -> str:
        if language == "console":
            return f"```console\n{''.join(map(self._run, COMMANDS.findall(text)))}```"
        if name is not None:
            path = self.folder / name
            path.write_text(_edited(path, text) if language == "diff" else text)
        return whole

    def _run(self, command: str) -> str:
        words = shlex.split(command)
        if words[0] == "cd":
            self.here = (self.here / words[1]).resolve()
            return f"$ {command}\n"
        if words[:2] == ["pip", "install"]:
            self._install(words[2:])
            return f"$ {command}\n"
        names = os.pathsep.join([str(self._python.parent), os.environ["PATH"]])
        clean = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
        done = subprocess.run(
            [self._python.parent / words[0], *words[1:]],
            cwd=self.here,
            env=clean | {"PATH": names, "COLUMNS": "100"},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        assert done.returncode == 0, f"{command}: {done.returncode}\n{done.stdout}"
        printed = done.stdout.replace(str(self.folder), "~")
        lines = [
            line.rstrip()
            for line in printed.splitlines()
            if line != "compiling kernels (first run on this machine only)"
        ]
        return "".join(f"{line}\n" for line in (f"$ {command}", *lines))

    def _install(self, words: list[str]) -> None:
        what = [self._wheel if word == "scaloft-fi" else word for word in words if word != "--quiet"]
        pip_install(self._python, *what, cwd=self.here)
        if self._wheel in what:
            lend_kernels(self._python)


def _edited(path: Path, diff: str) -> str:
    """The file with the lines `+` in place of the lines `-`, where the lines with neither stand in it, once."""
    lines = diff.splitlines(keepends=True)
    before = "".join(line[1:] for line in lines if line[0] in " -")
    after = "".join(line[1:] for line in lines if line[0] in " +")
    text = path.read_text()
    assert text.count(before) == 1, f"{path.name} has these lines {text.count(before)} times:\n{before}"
    return text.replace(before, after)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as made:
        follower = Follower(Path(made), wheel_of(Path(made)))
        text = follower.followed(PAGE.read_text())
        PAGE.write_text(text)
        shutil.rmtree(PICTURES, ignore_errors=True)
        PICTURES.mkdir()
        for name, content in follower.pictures(text).items():
            (PICTURES / name).write_bytes(content)
    sys.stdout.write(f"{PAGE}\n")
