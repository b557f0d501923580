"""The benchmarks import this module first: it selects the package of this checkout, and one thread."""

import argparse
import os
import sys
from collections.abc import Mapping
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))


def parser(about: str | None) -> argparse.ArgumentParser:
    """The options of a benchmark with this docstring."""
    return argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)


def tell(figures: Mapping[str, object]) -> None:
    """Print figures by name, a line for each."""
    for name, figure in figures.items():
        print(f"{name:32} {figure}")
