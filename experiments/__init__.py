"""What was flown once for a published page: flights, analysis, page; `python -m experiments.NAME` in the repository.

A plan is registered, in a commit of its own, before anything flies; it stands at the beginning of its page in
`results/published/`, and its script takes it from there.
"""

import os
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy is imported
ROOT = Path(__file__).resolve().parents[1]
PUBLISHED = ROOT / "results" / "published"
