"""Imported before numpy: asks OpenBLAS for the kernels of the published flights, where the processor can run them."""

import os
from pathlib import Path

KERNELS = "SkylakeX"
"""The kernels with which the published flights were flown, as OpenBLAS names them."""
FLAGS = frozenset({"avx512f", "avx512cd", "avx512bw", "avx512dq", "avx512vl"})
"""What a processor must have to run these kernels, as Linux names it."""


def choose(cpuinfo: Path = Path("/proc/cpuinfo")) -> bool:
    """Ask OpenBLAS for the kernels, which it reads from the environment when numpy is imported.

    Returns:
        Whether the processor can run them; on any other nothing is asked.
    """
    lines = cpuinfo.read_text(encoding="utf-8").splitlines() if cpuinfo.is_file() else []
    flags = next((set(line.split()) for line in lines if line.startswith("flags")), set())
    if not flags >= FLAGS:
        return False
    os.environ["OPENBLAS_CORETYPE"] = KERNELS.upper()
    return True


CHOSEN = choose()
