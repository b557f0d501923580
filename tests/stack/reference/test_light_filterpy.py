"""filterpy is imported without the modules that take long, and what it wants of them works all the same."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[3]

PROGRAM = """
import sys
import numpy
import scipy
from scaloft_fi.stack.reference.estimator import LATE, KalmanFilter
assert not {*LATE} & {*sys.modules}
assert not {"stats", "ndimage"} & {*vars(scipy)} and "f2py" not in vars(numpy)
from filterpy.stats import logpdf
likelihood = logpdf([1.0, 0.5], [0.0, 0.0], [[2.0, 0.3], [0.3, 1.0]])
import scipy.stats
assert likelihood == scipy.stats.multivariate_normal.logpdf([1.0, 0.5], [0.0, 0.0], [[2.0, 0.3], [0.3, 1.0]])
import filterpy.stats.stats
assert filterpy.stats.stats.norm(2, 3).pdf(1.0) == scipy.stats.norm(2, 3).pdf(1.0)
from filterpy.discrete_bayes import predict
assert predict([0.0, 1.0, 0.0], 1, [0.1, 0.8, 0.1]).tolist() == [0.1, 0.1, 0.8]
import numpy.f2py
assert numpy.f2py.get_include()
kf = KalmanFilter(dim_x=1, dim_z=1)
kf.predict()
kf.update(1.0)
assert kf.likelihood > 0.0
"""


def test_it_comes_without_them_and_computes_when_asked() -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_where_scipy_stats_is_there_already_it_is_used() -> None:
    program = re.sub("^assert not .*$", "", f"import scipy.stats\n{PROGRAM}", flags=re.MULTILINE)
    program += "assert filterpy.stats.stats.norm is scipy.stats.norm\n"
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
