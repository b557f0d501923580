"""The reference study, and the published flights of its grid."""

from __future__ import annotations

import pytest

from experiments import ROOT
from scaloft_fi.study import Study


@pytest.fixture(scope="session")
def study() -> Study:
    return Study.open(ROOT)
