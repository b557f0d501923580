"""Settings of all tests: Hypothesis draws the same examples in every run, at any speed."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from options import EFFORT, usually
from processes import ROOT
from studies import copied

import scaloft_fi.mutants.reference  # noqa: F401 - a study that names the reference stack declares its operators so
from scaloft_fi.campaign.processes import HANGUP
from scaloft_fi.study import Study

collect_ignore = ["support/ros2_border.py"]
"""A program for a Python with ROS 2."""

for name in ("COLUMNS", "FORCE_COLOR", "CLICOLOR_FORCE"):
    os.environ.pop(name, None)  # texts are as wide and as plain as where no terminal is
for number in HANGUP:
    signal.signal(number, signal.SIG_DFL)  # `nohup` has it ignored, and tests send it


FIRST = {"test_share.py": 0, "test_house_rules.py": 1}
"""A file that compiles the kernels, and one that takes about as long without them."""
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
MEMORY, ROOM = Path("/dev/shm"), 4 << 30
"""Where files are in memory on Linux, and how much room there has to be [bytes]."""


def pytest_configure(config: pytest.Config) -> None:
    """Keep the order of the files, and temporary files in memory.

    pytest-xdist would begin with the files of many tests, whatever they take.  On a disk, SQLite waits for it at each
    flight that it saves.
    """
    config.option.loadscopereorder = False
    EFFORT.release = config.option.release
    settings.register_profile("scaloft-fi", derandomize=True, deadline=None, max_examples=usually(10, release=200))
    settings.load_profile("scaloft-fi")
    if _runs_programs(MEMORY) and shutil.disk_usage(MEMORY).free > ROOM:
        os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", str(MEMORY))


@pytest.fixture(scope="session")
def study() -> Study:
    """The reference study, which no test changes."""
    return Study.open(ROOT)


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A study of one's own: a copy of the reference study."""
    return copied(tmp_path)


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """A Chromium for the whole process: Playwright starts once in it."""
    found = next((path for path in map(shutil.which, BROWSERS) if path), None)
    if found is None:
        reason = f"no browser: none of {', '.join(BROWSERS)} on the path"
        if os.environ.get("SCALOFT_FI_BROWSER") == "required":
            pytest.fail(reason)
        pytest.skip(reason)
    sync = pytest.importorskip("playwright.sync_api")
    with sync.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=found, args=["--no-sandbox", "--disable-gpu"])
        yield chromium
        chromium.close()


def _runs_programs(folder: Path) -> bool:
    return os.access(folder, os.W_OK) and not os.statvfs(folder).f_flag & os.ST_NOEXEC


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--release`: what takes too long for every change."""
    parser.addoption("--release", action="store_true", help="also run the tests marked release, before a release")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what is for a release, and run files that fly first: a long one at the end would fly alone.

    What is seen in a browser is for a release too.

    A file stays in one process.  The first one compiles what all others load; the second has other work for that time.
    """
    for item in items:
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker("release")
    if not EFFORT.release:
        late = [item for item in items if item.get_closest_marker("release")]
        config.hook.pytest_deselected(items=late)
        items[:] = [item for item in items if item not in late]
    flying = {item.path for item in items if item.get_closest_marker("flight")}
    items.sort(key=lambda item: FIRST.get(item.path.name, len(FIRST) + (item.path not in flying)))
