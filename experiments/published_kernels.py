"""Select OpenBLAS's kernels of the published flights, if the processor can run them.  Import this before numpy."""

import os
import sys
from pathlib import Path

KERNELS = "SkylakeX"
"""OpenBLAS's name of the kernels of the published flights."""
FLAGS = frozenset({"avx512f", "avx512cd", "avx512bw", "avx512dq", "avx512vl"})
"""Linux's name of the processor feature that these kernels need."""


def choose(cpuinfo: Path = Path("/proc/cpuinfo")) -> bool:
    """Set the environment variable that OpenBLAS reads when numpy is imported.

    Returns:
        Whether the processor can run the kernels; if not, the environment stays unchanged.
    """
    lines = cpuinfo.read_text(encoding="utf-8").splitlines() if cpuinfo.is_file() else []
    flags = next((set(line.split()) for line in lines if line.startswith("flags")), set())
    if not flags >= FLAGS:
        return False
    os.environ["OPENBLAS_CORETYPE"] = KERNELS.upper()
    return True


CHOSEN = "numpy" not in sys.modules and choose()
"""Where numpy is loaded, the variable would reach only the processes that this one starts, and they fly other bits."""
