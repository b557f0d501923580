"""filterpy is imported without `scipy.stats`, and what it wants of `scipy.stats` works all the same."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[3]

PROGRAM = """
import sys
from scaloft_fi.stack.reference.light_filterpy import KalmanFilter
assert "scipy.stats" not in sys.modules
from filterpy.stats import logpdf
likelihood = logpdf([1.0, 0.5], [0.0, 0.0], [[2.0, 0.3], [0.3, 1.0]])
import scipy.stats
assert likelihood == scipy.stats.multivariate_normal.logpdf([1.0, 0.5], [0.0, 0.0], [[2.0, 0.3], [0.3, 1.0]])
import filterpy.stats.stats
assert filterpy.stats.stats.norm(2, 3).pdf(1.0) == scipy.stats.norm(2, 3).pdf(1.0)
kf = KalmanFilter(dim_x=1, dim_z=1)
kf.predict()
kf.update(1.0)
assert kf.likelihood > 0.0
"""


def test_it_comes_without_scipy_stats_and_computes_likelihoods_when_asked() -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_where_scipy_stats_is_there_already_it_is_used() -> None:
    program = "import scipy.stats\n" + PROGRAM.replace('assert "scipy.stats" not in sys.modules\n', "")
    program += "assert filterpy.stats.stats.norm is scipy.stats.norm\n"
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
