"""Does situation coverage predict kills?  Ways to choose situations, compared on the flights of a campaign.

    python -m experiments.coverage_against_kills [--study DIR] [--campaign NAME] [--output DIR]

Every way to choose k situations is compared with k random ones: what they cover, how many mutants and how many
different sets of kills they meet.  Writes `coverage_against_kills.md` and `.svg` into the output folder.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))


# isort: split

import argparse
from collections.abc import Sequence

from experiments import ROOT
from experiments.coverage_against_kills.curve_picture import curve_picture
from experiments.coverage_against_kills.curve_tables import curve_tables
from experiments.coverage_against_kills.curves import curves
from experiments.coverage_against_kills.prediction import predict
from experiments.coverage_against_kills.trial import trial
from scaloft_fi.analysis.score import score_of
from scaloft_fi.errors import InputError
from scaloft_fi.study import Study
from scaloft_fi.verbs.snapshot import snapshot
from scaloft_fi.views.table import Format, render

NAME = "coverage_against_kills"


def pages(study: Study, campaign: str) -> dict[str, str]:
    """By file name the tables (Markdown) and the picture (SVG) of a campaign.

    Raises:
        InputError: there is no campaign, or no default mutant was flown in it.
    """
    with snapshot(study, campaign) as now:
        rulings, spending = now.rulings, now.spending
    scored = score_of(rulings, study.roster, study.space, spending)
    flown = trial(scored, rulings, study.roster, study.space, spending)
    if flown is None:
        raise InputError("coverage against kills needs default mutants of credible cells: none was flown")
    followed = curves(flown)
    tables = render(curve_tables(followed, predict(followed)), Format.MARKDOWN)
    return {f"{NAME}.md": tables, f"{NAME}.svg": curve_picture(followed)}


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the pages of a campaign."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--study", type=Path, default=ROOT)
    parser.add_argument("--campaign", default="reference", help="where the flights are")
    parser.add_argument("--output", type=Path, default=ROOT / "results" / "published" / "reference")
    options = parser.parse_args(arguments)
    for name, text in pages(Study.open(options.study), options.campaign).items():
        (options.output / name).write_text(text, encoding="utf-8")
        print(options.output / name)


if __name__ == "__main__":
    main()
