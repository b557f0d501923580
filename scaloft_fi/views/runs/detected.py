"""What a campaign has detected so far, by guideword, while drones still fly."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from scaloft_fi.analysis.detection import Spending
from scaloft_fi.analysis.score import score_of
from scaloft_fi.console import width, wrapped
from scaloft_fi.judge.outcome import Outcome
from scaloft_fi.judge.status import rulings_of
from scaloft_fi.study import Study


def detected_so_far(study: Study, outcomes: Iterable[Outcome], spending: Spending) -> list[str]:
    """Lines of what `scaloft-fi score` would count as detected now, of the mutants flown so far.

    Args:
        study: the study.
        outcomes: what the campaign holds.
        spending: of the campaign's alpha.
    """
    scored = score_of(rulings_of(outcomes), study.roster, study.space, spending)
    faults = scored.counted or [mutant for mutant in scored.mutants if mutant.flown]
    flown = Counter(mutant.subject.guideword for mutant in faults)
    detected = Counter(mutant.subject.guideword for mutant in faults if mutant.detected)
    if not flown:
        return []
    known = [word.id for word in study.matrix.guidewords if flown[word.id]]
    words = "  ".join(f"`{word} {detected[word]}/{flown[word]}`" for word in known)
    text = f"detected so far: {detected.total()} of {flown.total()} flown:  {words}"
    return wrapped(text, width() - 1, "", "  ").replace("`", "").split("\n")
