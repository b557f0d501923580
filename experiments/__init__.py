"""What was flown once for a published page: plan, flights, page; `python -m experiments.NAME` in the repository.

A plan is registered, in a commit of its own, before anything flies; data and pages are in `results/published/`.
"""

import os
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy is imported
ROOT = Path(__file__).resolve().parents[1]
