"""The process of the command `scaloft-fi`, also as `python -m scaloft_fi`: a signal ends it with one sentence."""

from __future__ import annotations


def start() -> None:
    """Run the command line in this process."""
    import _signal  # type: ignore[import-not-found]  # `signal` without its enumerations, which take long to import

    if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)  # ends the process without a word, until there is a handler
    from scaloft_fi.output import end_at_signals, ignore_signals

    end_at_signals()
    from scaloft_fi.cli import main

    try:
        main()
    finally:
        ignore_signals()  # what is left to do has no place for a traceback


if __name__ == "__main__":
    start()
