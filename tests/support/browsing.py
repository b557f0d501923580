"""A real Chromium, and one page opened in it from disk."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

OPEN = {"flight": "#sheet .map", "mutant": "#sheet .sheet-body", "cell": "#sheet .mutant"}
"""What shows that a sheet is open, by its kind."""
NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")


class Visit:
    """One page opened from disk; remembers what the console said and what was asked of a network."""

    def __init__(self, browser: Any, path: Path, fragment: str = "", **context: Any) -> None:
        self.context = browser.new_context(**{"viewport": {"width": 1280, "height": 900}, **context})
        self.page = self.context.new_page()
        self.said: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", lambda message: self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(path.as_uri() + fragment)
        self.page.wait_for_selector("#kills td.state")
        if fragment:
            self.page.wait_for_selector(OPEN[fragment[1:].partition("=")[0]])

    def hash(self) -> str:
        return str(self.page.evaluate("location.hash"))

    def close(self) -> None:
        self.context.close()
        assert self.said == []
        assert [url for url in self.asked if not url.startswith(("file:", "data:"))] == []
        assert len([url for url in self.asked if url.startswith("file:")]) == 1


Opened = Callable[..., Visit]
