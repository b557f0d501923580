"""Which source files enter the keys of flights, and how what is read of them is kept."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from options import cases

import scaloft_fi
from scaloft_fi import sources
from scaloft_fi.errors import InputError
from scaloft_fi.sources import SourceCache, closure, digest_of, read


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package in the place of ours; it has folders `fly` and `show`."""
    for name in ("fly", "show"):
        (tmp_path / "scaloft_fi" / name).mkdir(parents=True)
        (tmp_path / "scaloft_fi" / name / "__init__.py").touch()
    (tmp_path / "scaloft_fi" / "__init__.py").write_text("__version__ = '1'\n")
    monkeypatch.setattr(sources, "_ROOT", tmp_path)
    return tmp_path / "scaloft_fi"


@cases("text")
def test_whatever_way_a_module_is_imported_it_is_in_the_closure(package: Path, text: str):
    (package / "fly" / "craft.py").write_text(text)
    (package / "fly" / "wing.py").write_text("from scaloft_fi.fly.spar import area\n")
    (package / "fly" / "spar.py").write_text("area = 1.0\n")
    (package / "show" / "page.py").write_text("import scaloft_fi.fly.craft\n")
    assert closure(["scaloft_fi.fly.craft"]).keys() == {
        f"scaloft_fi.{name}" for name in ("fly", "fly.craft", "fly.wing", "fly.spar")
    }


WING, ROTOR, BESIDE = (
    ["fly", "fly.craft", "fly.wing"],
    ["fly.craft", "fly.rotor"],
    ["scaloft_fi.fly.wing", "scaloft_fi.fly"],
)


@pytest.mark.parametrize(
    ("files", "beside", "found"),
    [
        ({"fly/__init__": "from .wing import area\n"}, (), WING),
        (
            {"fly/craft": "if TYPE_CHECKING:\n    import scaloft_fi.show.page\nelse:\n    from . import wing\n"},
            (),
            WING,
        ),
        ({"fly/craft": "from . import rotor, wing\n", "fly/wing": "from .spar import area\n"}, BESIDE, ROTOR),
    ],
    ids=["what a package imports itself", "not what type checkers import", "not what only another imports"],
)
def test_what_is_imported_is_in_the_closure(
    package: Path, files: dict[str, str], beside: tuple[str, ...], found: list[str]
):
    for name in ("fly/craft", "fly/wing", "fly/rotor", "fly/spar", "show/page"):
        (package / f"{name}.py").touch()
    for name, text in files.items():
        (package / f"{name}.py").write_text(text)
    assert closure(["scaloft_fi.fly.craft"], beside=beside).keys() == {f"scaloft_fi.{name}" for name in found}


def test_the_digest_follows_what_is_imported_and_nothing_else(package: Path):
    (package / "fly" / "craft.py").write_text("from scaloft_fi.fly.wing import area\n")
    (package / "fly" / "wing.py").write_text("area = 1.0\n")
    (package / "show" / "page.py").write_text("from scaloft_fi.fly import craft\n")
    before = digest_of(closure(["scaloft_fi.fly.craft"]))
    (package / "show" / "page.py").write_text("from scaloft_fi.fly import wing\n")
    (package / "__init__.py").write_text("__version__ = '2'\n")
    assert digest_of(closure(["scaloft_fi.fly.craft"])) == before
    (package / "fly" / "wing.py").write_text("area = 2.0\n")
    assert digest_of(closure(["scaloft_fi.fly.craft"])) != before


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the plugin `kite` and the packages that it imports, and a `site-packages` with one of an index."""
    files = {
        "kite/__init__.py": "",
        "kite/stack.py": "import json, numpy, kite_nowhere\nfrom kite_lab.core import way\n",
        "kite/gain.txt": "1.0",
        "kite_lab/__init__.py": "",
        "kite_lab/core.py": "from kite_wheel import nearest\nway = nearest\n",
        "site-packages/kite_wheel/__init__.py": "import kite_far\nnearest = 1\n",
        "site-packages/Wheel-1.0.dist-info/METADATA": "Metadata-Version: 2.1\nName: Wheel\nVersion: 1.0\n",
        "site-packages/Wheel-1.0.dist-info/RECORD": "kite_wheel/__init__.py,sha256=0,1\n",
        "kite_far.py": "",
    }
    for name, text in files.items():
        path = tmp_path / "site" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    for folder in ("site", "site/site-packages"):
        monkeypatch.syspath_prepend(tmp_path / folder)
    monkeypatch.setattr(sources, "_version", sources._version.__wrapped__)
    monkeypatch.setattr(sources, "_installed", sources._installed.__wrapped__)
    return tmp_path / "site"


def test_the_closure_of_a_plugin_has_its_files_those_of_its_library_and_the_version_of_a_wheel(site: Path):
    found = closure(["kite.stack"])
    lab = {"kite_lab.__init__", "kite_lab.core"}
    assert found.keys() == {"kite.__init__", "kite.stack", "kite/gain.txt", "kite_wheel"} | lab
    assert found["kite_wheel"].meaning == "Wheel 1.0"
    assert closure(["kite.stack"], beside=found) == {}


WHEEL = "site-packages/Wheel-1.0.dist-info"


@cases("name", "text", "enters")
def test_what_can_change_what_a_plugin_does_changes_its_digest(site: Path, name: str, text: str, *, enters: bool):
    before = digest_of(closure(["kite.stack"]))
    path = site / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    assert (digest_of(closure(["kite.stack"])) != before) is enters


def test_of_a_package_that_was_installed_from_a_folder_the_files_count(site: Path):
    (site / WHEEL / "direct_url.json").write_text('{"url": "file:///lab", "dir_info": {}}')
    assert closure(["kite.stack"]).keys() >= {"kite_wheel.__init__", "kite_far"}


def test_a_package_with_more_than_commands_can_hash_is_refused(site: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sources, "FILE_BYTES", 2)
    with pytest.raises(InputError, match=r"kite: its files enter the keys of the flights of 'kite', and are more than"):
        closure(["kite.stack"])


def test_an_entry_that_does_not_exist_is_refused():
    for name in ("scaloft_fi.nowhere", "scaloft_fi_nowhere.module"):
        with pytest.raises(ModuleNotFoundError, match=name.partition(".")[0]):
            closure([name])


def test_the_package_itself_says_only_what_scripts_use():
    """Its `__init__` is left out of every closure, so it must decide nothing."""
    said = [ast.unparse(statement) for statement in ast.parse(Path(scaloft_fi.__file__).read_text()).body[1:]]
    imports = [one for one in said if one.startswith(("from ", "import ", "if TYPE_CHECKING:"))]
    rest = [one.partition("(")[0].partition(" = ")[0] for one in said if one not in imports]
    said_alone = [one for one in rest if not one.startswith(("'", '"', "__all__ += "))]
    assert said_alone == ["TYPE_CHECKING", "__all__", "_LATE", "def __getattr__", "def __dir__"]
    assert {name.partition(".")[0] for name in sources.read(Path(scaloft_fi.__file__)).imports} <= {
        "__future__",
        "importlib",
        "scaloft_fi",
        "typing",
    }


@cases("edited", "same")
def test_only_what_the_interpreter_does_is_part_of_the_hash_of_code(tmp_path: Path, edited: str, *, same: bool):
    first, second = tmp_path / "first.py", tmp_path / "second.py"
    first.write_text('"""Text."""\ndef f(x):\n    return x + 1\n')
    second.write_text(edited)
    assert (read(first).meaning == read(second).meaning) is same


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "scaloft-fi"


def kept(content: bytes = b"x = 1", reader: bytes = b"reader") -> object:
    """What a process finds of a content that another one kept."""
    return SourceCache(reader).get(content)


def keep() -> None:
    cache = SourceCache(b"reader")
    assert cache.get(b"x = 1") is None
    cache.put(b"x = 1", ("meaning", ("a", "b")))
    cache.save()


def test_a_later_process_finds_what_was_kept_for_the_same_content_and_reader_only(folder: Path):
    keep()
    assert len(list(folder.iterdir())) == 1
    assert kept() == ("meaning", ("a", "b"))
    assert kept(b"x = 2") is kept(reader=b"another") is None


@pytest.mark.parametrize("content", [b"", b"[1]", b"{", b'{"a": 1}', b"[" * 100_000, b"\xff"])
def test_a_file_that_holds_nonsense_counts_as_empty_and_is_written_anew(folder: Path, content: bytes):
    keep()
    (path,) = folder.iterdir()
    path.write_bytes(content)
    keep()
    assert kept() == ("meaning", ("a", "b"))


def test_a_folder_that_cannot_be_written_is_no_hindrance(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    cache = SourceCache(b"reader")
    assert cache.get(b"x = 1") is None
    cache.put(b"x = 1", ("meaning", ()))
    cache.save()
    assert cache.get(b"x = 1") == ("meaning", ())


def test_what_has_nothing_new_writes_nothing(folder: Path):
    SourceCache(b"reader").save()
    assert not folder.exists()
