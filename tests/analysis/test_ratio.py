from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaloft_fi.analysis.roster import Ratio, plain


@given(st.integers(0, 100), st.integers(1, 100))
def test_a_ratio_prints_part_whole_and_share(part: int, whole: int) -> None:
    part = min(part, whole)
    assert str(Ratio(part, whole)) == f"{part}/{whole} = {100 * part / whole:.0f} %"
    assert plain(Ratio(part, whole)) == {"part": part, "whole": whole}


def test_nothing_of_nothing_is_not_a_number() -> None:
    assert (str(Ratio(0, 0)), Ratio(0, 0).value) == ("0/0 = n/a", None)


@pytest.mark.parametrize(("part", "whole"), [(2, 1), (-1, 3)])
def test_what_is_no_share_is_refused(part: int, whole: int) -> None:
    with pytest.raises(ValueError, match="no share"):
        Ratio(part, whole)
