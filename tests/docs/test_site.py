"""The site builds without a warning and without a network, and its reference has all that the code has."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from pages import embedded
from printed import printed_enumerations
from processes import ROOT

from scaloft_fi.cli import command_of
from scaloft_fi.errors import ExitCode
from scaloft_fi.verbs import VERBS
from scaloft_fi.verbs.export.dossier import EXPORT
from scaloft_fi.verbs.schema import ANSWERS, DOCUMENTS
from scaloft_fi.views.table import TERMS

pytestmark = pytest.mark.release
NEEDED = ("material",)
LOADED = {("script", "src"), ("link", "href"), ("img", "src"), ("iframe", "src")}
"""What a browser loads when it opens a page."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built into a folder of its own, with a way to the network that leads nowhere."""
    if lacking := [name for name in NEEDED if find_spec(name) is None]:
        pytest.skip(f"the site needs {', '.join(lacking)}: pip install -e '.[docs]'")
    folder = tmp_path_factory.mktemp("site")
    nowhere = dict.fromkeys(("http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY"), "http://127.0.0.1:9")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", folder],
        cwd=ROOT,
        env=os.environ | nowhere | {"NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "WARNING" not in done.stderr, done.stderr
    return folder


class _Loads(HTMLParser):
    """Collects what a page loads, and its text."""

    def __init__(self) -> None:
        super().__init__()
        self.loaded: list[str] = []
        self.text: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.loaded += [value or "" for name, value in attrs if (tag, name) in LOADED]

    def handle_data(self, data: str) -> None:
        self.text.append(data)


def _read(path: Path) -> _Loads:
    parser = _Loads()
    parser.feed(path.read_text())
    return parser


def _text(site: Path, page: str) -> str:
    return " ".join("".join(_read(site / page).text).split())


def test_no_page_loads_anything_from_a_network(site: Path):
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 40
    outside = {page.name: [url for url in _read(page).loaded if "//" in url] for page in pages}
    assert {page: urls for page, urls in outside.items() if urls} == {}
    styles = "".join(path.read_text() for path in site.rglob("*.css"))
    assert re.findall(r"url\([\"']?(?:https?:)?//[^)]*", styles) == []


def test_no_page_names_a_place_of_one_machine(site: Path):
    named = re.compile(r"(?<![\w.])/(?:home|root|work|tmp|Users)/\w|\bfile://")
    found = {page.name: named.findall(" ".join(_read(page).text)) for page in site.rglob("*.html")}
    assert {page: places for page, places in found.items() if places} == {}


def test_the_glossary_has_every_term(site: Path):
    text = _text(site, "glossary.html")
    assert [term.name for term in TERMS if term.name not in text] == []


def test_the_reference_has_every_verb_and_option(site: Path):
    page = (site / "reference" / "verbs.html").read_text()
    sections = dict(re.findall(r'<h3 id="scaloft-fi-(\w+)">(.*?)(?=<h3 |\Z)', page, re.DOTALL))
    assert set(VERBS) <= set(sections)
    options = [(verb, option) for verb in VERBS for one in command_of(verb).params for option in one.opts]
    named = [(verb, option) for verb, option in options if option.startswith("--")]
    assert len(named) > 100
    assert [(verb, option) for verb, option in named if option not in sections[verb]] == []


def test_the_reference_links_the_schema_of_every_document_and_answer(site: Path):
    for page, folder, names in (("yaml_keys", "study", DOCUMENTS), ("outputs", "output", ANSWERS)):
        text = (site / "reference" / f"{page}.html").read_text()
        linked = re.findall(rf'schemas/{folder}/(\w+)\.json"', text)
        assert sorted(linked) == sorted(names)
        assert {path.stem for path in (site / "schemas" / folder).iterdir()} == set(names)
    assert [one.files for one in DOCUMENTS.values() if one.files not in _text(site, "reference/yaml_keys.html")] == []


def test_the_reference_has_every_column_of_the_export(site: Path):
    text = (site / "reference" / "columns.html").read_text()
    assert [name for name in EXPORT.keys if f"<code>{name}</code>" not in text] == []


def test_the_glossary_has_every_value_that_is_printed(site: Path):
    text = _text(site, "glossary.html")
    values = {f"{one.__name__}.{value}": str(value) for one in printed_enumerations() for value in one}
    assert len(values) > 60
    assert [name for name, shown in values.items() if shown not in text] == []


def test_the_site_has_at_most_60_000_words(site: Path):
    words = {page.name: len(_words(page.read_text())) for page in site.rglob("*.html")}
    assert words["tutorial.html"] > 3000
    assert sum(words.values()) <= 60_000


def _words(page: str) -> list[str]:
    """The words of the text of a page, without the navigation that all pages have."""
    article = re.search(r"<article.*?</article>", page, re.DOTALL)
    return re.sub(r"<(script|style).*?</\1>|<[^>]+>", " ", article[0], flags=re.DOTALL).split() if article else []


def test_the_reference_has_every_exit_code(site: Path):
    text = (site / "reference" / "outputs.html").read_text()
    assert [int(code) for code in re.findall(r"<td>(\d+)</td>", text)] == list(ExitCode)


def test_search_answers_where_the_site_is_opened_from_disk(site: Path, browser: Any):
    with browser.new_context() as context:
        page = context.new_page()
        asked: list[str] = []
        page.on("request", lambda request: asked.append(request.url))
        page.goto((site / "index.html").as_uri())
        page.locator("[data-md-component=search-query]").click()
        page.keyboard.type("subsumed by")
        page.locator(".md-search-result__link[href*='glossary.html']").first.wait_for()
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:", "about:"))] == []


def test_the_report_of_the_published_campaign_is_on_the_site(site: Path):
    text = (site / "experiments" / "reference" / "report.html").read_text(encoding="utf-8")
    assert embedded(text, "figures")["flights"] == 13821
    for page in ("index.html", "experiments/index.html"):
        assert 'reference/report.html"' in (site / page).read_text(encoding="utf-8")
