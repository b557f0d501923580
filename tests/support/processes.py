"""What runs on this machine, as Linux tells."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path


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
