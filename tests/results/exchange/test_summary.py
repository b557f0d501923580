from __future__ import annotations

from builders import outcome
from dossiers import dossier

from scaloft_fi.results.exchange.summary import summary


def test_the_page_names_survivors_killed_mutants_and_red_baselines() -> None:
    flights = [
        outcome(),
        outcome(situation="T0O0W0D1H1", violated={"SR2": 4.0}),
        outcome("LATE-human@3s", violated={"SR2": 7.0}),
        outcome("NO-human@100%", digest="x"),
    ]
    page = summary(dossier(flights))
    headings = [line for line in page.splitlines() if line.startswith("### ")]
    assert headings[1:] == ["### 1 survivors", "### 1 killed", "### 1 situations with a red baseline"]
    survivors, killed, red = (page.split(heading)[1].split("###")[0] for heading in headings[1:])
    assert "NO-human@100%" in survivors
    assert "LATE-human@3s" in killed
    assert "T0O0W0D1H1" in red
    assert "mutation score | 1/2 = 50 %" in page
