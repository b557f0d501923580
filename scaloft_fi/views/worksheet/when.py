"""When a fault strikes, for readers: a table of its times and one of its events, each phase on a rail of the flight."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from scaloft_fi.analysis.detection import Verdict
from scaloft_fi.analysis.margin import Strike, When
from scaloft_fi.views.tables.table import Table

HEADERS = ("phase", "acts at [s]", "in the flight", "kills", "verdict")
RAIL = 30
"""Width of the rail that stands for the flight [characters]."""
LEGEND = (
    "Acts at: first altered sample, median over the flights (earliest to latest); kills: situations with a kill, of "
    "those that put it to the test.  In the flight: X some kill, o none, - not put to the test, at the median."
)


def when_tables(found: Iterable[When]) -> tuple[Table, ...]:
    """For each fault a table of the times at which it was flown, and one of the events."""
    return tuple(
        _table(when, strikes, kinds)
        for when in found
        for kinds, strikes in (("times", when.told(at_events=False)), ("events", when.told(at_events=True)))
        if strikes
    )


def _table(when: When, strikes: Sequence[Strike], kinds: str) -> Table:
    detected = sum(strike.verdict is Verdict.DETECTED for strike in strikes)
    rows = tuple(
        (strike.phase or "#0s", _acts(strike), _rail(strike, when.lasts_s), strike.kills.short, strike.verdict.words)
        for strike in strikes
    )
    told = f"Detected at {detected} of {len(strikes)} {kinds}; the rail is the baseline's {when.lasts_s:.0f} s."
    return Table(f"When {when.fault} strikes: {kinds}", HEADERS, rows, (told, LEGEND))


def _acts(strike: Strike) -> str:
    if strike.acts_s is None:
        return "never"
    first, median, last = strike.acts_s
    return f"{median:.1f}" + (f" ({first:.1f} to {last:.1f})" if first < last else "")


def _rail(strike: Strike, lasts_s: float) -> str:
    """The flight as a row of dots, with the phase's mark where it acts.

    >>> from scaloft_fi.analysis.roster import Ratio
    >>> _rail(Strike("NO-depth@3s#sight", "#sight", True, (5.0, 6.0, 7.0), Ratio(1, 4), Verdict.DETECTED), 60.0)
    '...X..........................'
    """
    if strike.acts_s is None or not lasts_s:
        return "." * RAIL
    place = min(RAIL - 1, int(RAIL * strike.acts_s[1] / lasts_s))
    return "." * place + mark_of(strike) + "." * (RAIL - 1 - place)


def mark_of(strike: Strike) -> str:
    """X for a phase with a kill, o for one without, - for one that nothing puts to the test."""
    return "X" if strike.kills.part else "o" if strike.kills.whole else "-"
