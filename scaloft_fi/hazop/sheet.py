"""Read HAZOP and STPA sheets of other tools: rows of a workbook or of CSV, as deviations that a study has or lacks.

A sheet is read as its people wrote it: columns by their heads in several languages, merged cells, blank cells that mean
"as above", guidewords in a column of their own, in the deviation, or as heads of columns.
"""

from __future__ import annotations

import csv
import io
import re
import unicodedata
import warnings
import zipfile
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, time
from itertools import pairwise, zip_longest
from pathlib import Path

from scaloft_fi.document import MIB, read_apart, read_bytes
from scaloft_fi.errors import InputError, did_you_mean, nearest, needed, shown
from scaloft_fi.hazop.matrix import Cell, CellStatus, Matrix

MOST_ROWS, MOST_COLUMNS, MOST_TEXT = 20_000, 500, 10_000
"""Of a sheet that people fill in; and characters of one of its cells."""
SHEET_BYTES = 64 * MIB
HEAD_WITHIN = 40
"""Rows of a sheet in which its heads are looked for."""


def _words(file: str) -> Mapping[str, str]:
    """The words of a file of this folder, by key; a line that begins with blanks goes on with the one above."""
    text = Path(__file__).with_name(file).read_text(encoding="utf-8").replace("\n  ", "")
    return dict(line.split(": ", 1) for line in text.splitlines())


HEADS = _words("heads.txt")
"""Heads by what stands below them, in small letters without accents."""
TEXTS = ("deviation", "causes", "effect", "safeguards", "recommendation", "severity")
"""What makes a row one that says something."""
SAID = (*TEXTS, "likelihood", "responsible", "due", "action_status")
"""What a draft takes of a row."""
DOWN = ("node", "parameter", "intent", "guideword", "deviation")
"""Columns whose blank cells mean "as above"; a deviation does only where all of them are blank."""
DESCRIPTIONS = ("description", "beschreibung", "text", "descripcion", "descrizione")

WORDS = _words("guidewords.txt")
"""Guidewords of IEC 61882 and the extension of the reference study, as people write them."""
STPA: Sequence[tuple[str, tuple[str, ...]]] = (
    (r"not (provid|giv|issued|send)\w*|nicht (bereit|geg)\w*|non fourni\w*|no (proporciona|suministra)\w*", ("NO",)),
    (r"(stopped|ends?|stop\w*) too (soon|early)|zu fruh (beendet|gestoppt)|arret\w* trop tot", ("LESS",)),
    (r"(applied|provided|lasts?|continued) too long|zu lange?|trop longtemps", ("MORE",)),
    (r"too early|zu fruh|trop tot", ("EARLY",)),
    (r"too late|zu spat|trop tard", ("LATE",)),
    (r"(out of|wrong|incorrect) (order|sequence)|reihenfolge|mauvais ordre", ("BEFORE", "AFTER")),
    (r"provid\w*|given|causes hazard|bereitgestellt|gegeben|fourni\w*", ("UNINTENDED", "ASWELLAS")),
)
"""The ways in which a control action is unsafe (Leveson and Thomas, STPA Handbook, 2018, p. 35), by their heads: the
guidewords that say the same, the first that the study has.  Too short and too long are LESS and MORE of its
duration."""
PROVIDED = STPA[-1][1]
FEWEST_HEADS = 3
"""Heads that a sheet must have, where the user names none."""
MOST_HEAD = 120
"""Characters of a head."""
_NOTHING = frozenset(("n a", "na", "not applicable", "not hazardous", "nicht gefahrlich", "entfallt"))
"""What people write where nothing deviates."""
_EMPTY = _NOTHING | {"", "none", "x", "tbd"}
LISTS = ("causes", "requirements")
"""What is a list, in which `;` or a line break parts entries."""
_LOST, _ERROR = "\0", re.compile(r"#(REF!|VALUE!|NAME\?|DIV/0!|NULL!|NUM!|N/A|SPILL!|CALC!)")
"""What stands for a formula without a stored value and for an error value; the error values."""


@dataclass(frozen=True)
class Line:
    """A row of a sheet that says something; of a sheet with guidewords for heads, one cell of the row.

    Attributes:
        place: sheet and row, `Sheet1:12`.
        texts: by the keys of `HEADS`; what is blank is left out.
        keys: of the columns that the sheet has.
        words: the guidewords that its head may mean, where guidewords are heads.
    """

    place: str
    texts: Mapping[str, str]
    keys: frozenset[str] = frozenset()
    words: tuple[str, ...] = ()


def plain(text: str) -> str:
    """A text in small letters, without accents, signs and double blanks.

    >>> plain("  Schutz-Maßnahmen / Barrières ")
    'schutz massnahmen barrieres'
    """
    bare = unicodedata.normalize("NFKD", text.casefold().replace("œ", "oe"))
    return " ".join(re.sub(r"[\W_]+", " ", "".join(c for c in bare if not unicodedata.combining(c))).split())


def read_sheet(
    path: Path,
    columns: Mapping[str, str] | None = None,
    sheets: Collection[str] = (),
    unread: dict[str, list[str]] | None = None,
) -> tuple[Line, ...]:
    """The rows of a workbook (`.xlsx`) or of CSV.

    Args:
        path: the file.
        columns: heads of the file by key of `HEADS`, where they are other words than those.
        sheets: names of the sheets to read; by default all.
        unread: gets by sheet the heads and cells that were not read; none: the whole sheet.

    Raises:
        InputError: the file cannot be read, is larger than a sheet may be, or has no row of heads that are known.
    """
    kinds = {".xlsx": _workbook, ".xlsm": _workbook, ".csv": _csv, ".tsv": _csv, ".txt": _csv}
    kind = kinds.get(path.suffix.lower())
    if kind is None:
        raise InputError(f"{path}: must end in {', '.join(kinds)}")
    content = read_bytes(path, SHEET_BYTES)
    asked = {plain(head): key for key, head in (columns or {}).items()}
    pages = read_apart(path, lambda: kind(path, content))
    heads, lines, left = dict[str, None](), list[Line](), {} if unread is None else unread
    names = [name for name, _ in pages]
    for name in sheets:
        if name not in names:
            raise InputError(f"{path}: has no sheet {name!r}{did_you_mean(name, names)}")
    for name, rows in ((name, rows) for name, rows in pages if name in sheets or not sheets):
        begins = [at for at, row in enumerate(rows) if _is_head(row) and not (at and _is_head(rows[at - 1]))]
        for first, end in pairwise((0, *begins[1:], len(rows))):
            lines += _lines(name, rows[:end], first, asked, heads, left)
    if lacking := [key for head, key in asked.items() if head not in heads]:
        head = (columns or {})[lacking[0]]
        raise InputError(f"{path}: no column is headed {head!r}{did_you_mean(plain(head), heads)}")
    if not lines:
        told = ", ".join(shown(head) for head in list(heads)[:12])
        raise InputError(
            f"{path}: no row has the heads of a HAZOP or STPA sheet: a guideword or a deviation, beside a node or a "
            f"parameter; name them with --column deviation=HEAD{f' (read: {told})' if told else ''}"
        )
    return tuple(lines)


Rows = list[list[str]]
MARKED = re.compile(r"\A'(?='*[=+\-@＝＋－＠\s])")  # noqa: RUF001 - those, too, begin a formula
"""The mark before a text that would be a formula, as `worksheet --format csv` writes it."""


def _csv(path: Path, content: bytes) -> list[tuple[str, Rows]]:
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("utf-16" if content[:2] in (b"\xff\xfe", b"\xfe\xff") else "cp1252", errors="replace")
    first = text[: text.find("\n", 2000) + 1 or None]
    try:
        each = [line for line in first.splitlines() if line.strip()] or [""]
        counts = {one: [line.count(one) for line in each] for one in ",;\t|"}
        comma = max(counts, key=lambda one: (_heads_between(first, one), min(counts[one]), sum(counts[one])))
        rows = [list(row) for row in csv.reader(io.StringIO(text, newline=""), delimiter=comma)]
    except csv.Error as error:
        raise InputError(f"{path}: is no CSV: {error}") from None
    _check_size(path, "the table", len(rows), max(map(len, rows), default=0))
    return [("", [[_LOST if _ERROR.fullmatch(cell) else MARKED.sub("", cell) for cell in row] for row in rows])]


def _heads_between(text: str, comma: str) -> int:
    """The heads that are known in the row of a text that has most, where this sign stands between cells."""
    rows = csv.reader(io.StringIO(text, newline=""), delimiter=comma)
    return max((sum(_key(plain(cell)) is not None for cell in row) for row in rows), default=0)


def _workbook(path: Path, content: bytes) -> list[tuple[str, Rows]]:
    openpyxl = needed("openpyxl", f"{path}: reading it needs openpyxl", "xlsx")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as packed:  # which unpacks no more of a part than it declares
            parts = [part for part in packed.infolist() if part.filename.endswith(".xml")]
            if (unpacked := sum(part.file_size for part in parts)) > SHEET_BYTES:
                raise InputError(f"{path}: it unpacks to {unpacked:,} bytes of XML, and may to {SHEET_BYTES:,} at most")
            formulas = any(re.search(rb"<(\w+:)?f[ />]", packed.read(part)) for part in parts)
        with warnings.catch_warnings(action="ignore"):  # of parts that no cell depends on
            book = openpyxl.load_workbook(io.BytesIO(content), data_only=True)
            told = openpyxl.load_workbook(io.BytesIO(content)) if formulas else book
    except (InputError, MemoryError):
        raise
    except Exception as error:  # noqa: BLE001 - whatever a damaged workbook makes of the library
        raise InputError(f"{path}: is no workbook that can be read: {type(error).__name__}: {error}") from None
    pages = []
    for page, formed in zip(book.worksheets, told.worksheets, strict=True):
        for cell, typed in ((page._cells[at], typed) for at, typed in formed._cells.items()):
            if cell.data_type == "e" or (typed.data_type == "f" and cell.value is None):
                cell._value = _LOST  # which no workbook can hold
        # where something stands, not `max_row`: a column that is only coloured ends in row 1,048,576
        held = [at for at, cell in page._cells.items() if cell.value is not None]
        last, width = max((row for row, _ in held), default=0), max((column for _, column in held), default=0)
        _check_size(path, f"sheet {page.title!r}", last, width)
        rows = [
            ["" if cell is None else openpyxl.utils.escape.unescape(_text(cell)) for cell in row]
            for row in (page.iter_rows(max_row=last, max_col=width, values_only=True) if held else ())
        ]
        for merged in page.merged_cells.ranges:
            if merged.min_row > last or merged.min_col > width:
                continue
            for row in rows[merged.min_row - 1 : merged.max_row]:
                row[merged.min_col - 1] = rows[merged.min_row - 1][merged.min_col - 1]
        pages.append((page.title, rows))
    return pages


def _text(cell: object) -> str:
    """A value of a workbook, where a day is the moment at which it begins."""
    if isinstance(cell, datetime) and cell.time() == time():
        return cell.date().isoformat()
    return f"{cell:.15g}" if isinstance(cell, float) else str(cell)


def _check_size(path: Path, what: str, rows: int, columns: int) -> None:
    if rows > MOST_ROWS or columns > MOST_COLUMNS:
        allowed = f"at most {MOST_ROWS:,} rows and {MOST_COLUMNS} columns"
        raise InputError(f"{path}: {what} has {rows:,} rows and {columns:,} columns; it must have {allowed}")


def _lines(
    name: str, rows: Rows, first: int, asked: Mapping[str, str], heads: dict[str, None], unread: dict[str, list[str]]
) -> Iterator[Line]:
    """The rows of a table that begins with row `first` of a page; `heads` gets the heads, `unread` what is not read."""
    best: tuple[int, int, dict[int, str], dict[int, tuple[str, ...]], list[str]] = (0, 0, {}, {}, [])
    for at, row in enumerate(rows[first : first + HEAD_WITHIN], first):
        below = rows[at + 1] if at + 1 < len(rows) else []
        groups = _spread(row)
        for height, told, above in (
            (1, row, []),
            (2, [own or left for own, left in zip_longest(below, groups, fillvalue="")], groups),
        ):
            words = _words_of(told, asked)
            words = words if len(words) > 1 else {}
            roles = _roles(told, asked, words, above)
            heads |= dict.fromkeys(head for head in map(plain, told) if head and (roles or words))
            if len(roles) + len(words) > best[0]:
                best = (len(roles) + len(words), at + height, roles, words, told)
        if _is_head(row):
            break
    known, begin, roles, words, told = best
    keys = frozenset(roles.values())
    about = keys & {"node", "parameter", *TEXTS} - {"deviation"}
    named = words or "cell" in keys or (about and keys & {"guideword", "deviation"})
    left = unread.setdefault(name, [])
    if not named or (known < FEWEST_HEADS and not asked):
        left += ["the sheet, whose heads are not known"] * bool(rows)
        return
    left += (head for at, head in enumerate(told) if head.strip() and at not in roles and at not in words)
    before: dict[str, str] = {}
    for number, row in enumerate(rows[begin:], begin + 1):
        texts, lost = dict[str, str](), list[str]()
        for at, key in roles.items():
            text = (row[at].replace("\n", "; ") if key in LISTS else row[at]) if at < len(row) else ""
            text = " ".join(text.split())[:MOST_TEXT]
            if text == _LOST:
                lost.append(key)
            elif text and text not in texts.get(key, "").split("; "):
                texts[key] = f"{texts[key]}; {text}" if key in texts else text
        for key in ("node", "parameter"):
            if texts.get(key, before.get(key)) != before.get(key):  # a new node has guidewords of its own
                before.pop("guideword", None)
        if any(key in texts for key in ("node", "parameter", "guideword", "deviation")):
            before = {key: text for key, text in before.items() if key != "deviation"}
        before = {key: text for key, text in (before | texts).items() if key in DOWN and key not in lost}
        place = f"{name}:{number}" if name else f"{number}"
        if words:
            for at, meant in words.items():
                text = " ".join(row[at].split())[:MOST_TEXT] if at < len(row) else ""
                lost += [told[at]] * (text == _LOST)
                if plain(text) not in _EMPTY:
                    yield Line(place, {**before, **texts, "deviation": text}, keys, meant)
        elif any(key in texts for key in (*TEXTS, "cell", "rationale")):
            yield Line(place, {**before, **texts}, keys - {*lost})
        left += (f"{head} of row {number}, a formula without a value or an error" for head in lost)


def _spread(row: Sequence[str]) -> list[str]:
    """The heads of groups, above each of their columns; in the file each stands above the first."""
    found = list[str]()
    for cell in row:
        found.append(cell or (found[-1] if found else ""))
    return found


def _roles(
    told: Sequence[str], asked: Mapping[str, str], others: Collection[int], groups: Sequence[str]
) -> dict[int, str]:
    """What stands below each head that is known, by column; a word of `HEADS` goes before a head that has it inside.

    Below a group that is headed by cause or consequence every column tells of that; below one headed by deviation a
    description is the deviation.
    """
    found, exact = dict[int, str](), set[int]()
    for at, head in enumerate(map(plain, told)):
        if at in others or not head:
            continue
        group = _key(plain(groups[at])) if at < len(groups) else None
        own = asked.get(head) or _key(head)
        described = group == "deviation" and own is None and head in DESCRIPTIONS
        if described or (group in ("causes", "effect") and head not in asked):
            own = group
        if own:
            exact.add(at)
        key = own or next((key for key, known in HEADS.items() if _within(known, head)), None)
        if key is not None and (head in asked or key not in asked.values()):
            found[at] = key
    whole = {found[at] for at in exact if at in found}
    return {at: key for at, key in found.items() if at in exact or key not in whole}


_key = {one: key for key, known in HEADS.items() for one in known.split("|")}.get


def _is_head(row: Sequence[str]) -> bool:
    """Whether a row has as many heads as a table must have."""
    keys = {_key(plain(cell)) for cell in row if len(cell) < MOST_HEAD} - {None}
    return len(keys) >= FEWEST_HEADS and not keys.isdisjoint({"guideword", "deviation", "cell"})


def _within(known: str, head: str) -> bool:
    """Whether a head of a few words has one of these among them, or as a part of a long word."""
    short = len(head.split()) <= 6
    return short and any(f" {one} " in f" {head} " or (len(one) > 4 and one in head) for one in known.split("|"))


def _words_of(told: Sequence[str], asked: Mapping[str, str]) -> dict[int, tuple[str, ...]]:
    """The guidewords that heads may mean, by column: words of their own (not a lone "No."), or ways of STPA."""
    heads = [plain(head) for head in told]
    words = [(at, word) for at, head in enumerate(heads) if (word := guideword_of(head)) and head not in asked]
    found: dict[int, tuple[str, ...]] = (
        {at: (word,) for at, word in words} if len({word for _, word in words}) > 2 else {}
    )
    for at, head in enumerate(heads):
        if head not in asked and at not in found and len(head) < MOST_HEAD and (ways := _ways(head)):
            found[at] = ways
    return found


def _ways(text: str) -> tuple[str, ...]:
    """The guidewords that a way in which a control action is unsafe may mean."""
    meant = [words for pattern, words in STPA if re.search(pattern, text)]
    ways = meant[:1] if meant[:1] == [("NO",)] else [one for one in meant if one != PROVIDED] or meant
    return tuple(word for words in ways for word in words)


def _meant(words: tuple[str, ...], told: str, known: Sequence[str]) -> tuple[str, ...]:
    """Of the guidewords that a way may mean, those that a deviation tells of."""
    meant = [word for word in words if word in known]
    if len(meant) < 2 or words == PROVIDED:
        return tuple(meant[:1])
    ways = (words for pattern, words in STPA if re.search(pattern, told))
    spoken = (word for word in meant if any(f" {one} " in f" {told} " for one in WORDS[word].split("|")))
    found = (both[0] for words in ways if (both := [one for one in words if one in meant]))
    return tuple(dict.fromkeys(found)) or tuple(spoken)[:1]


def guideword_of(text: str) -> str | None:
    """The guideword that a word or two mean; None: no guideword.

    >>> guideword_of("Too late"), guideword_of("AS WELL AS"), guideword_of("zu früh"), guideword_of("blue")
    ('LATE', 'ASWELLAS', 'EARLY', None)
    """
    told = plain(text)
    return next((word for word, known in WORDS.items() if told and told in known.split("|")), None)


def named_words(line: Line, own: Mapping[str, str], known: Sequence[str]) -> tuple[str, ...]:
    """The guidewords that a row is about.

    Args:
        line: the row.
        own: guidewords by texts of the sheet, as the user says.
        known: guidewords.
    """
    said = {plain(text): word for text, word in own.items()}
    text, told = line.texts.get("guideword", ""), plain(line.texts.get("deviation", ""))
    if line.words:
        return _meant(line.words, told, known)
    if text:
        whole = said.get(plain(text)) or _known(text, known)
        parts = [whole] if whole else [said.get(plain(one)) or _known(one, known) for one in re.split(r"[/,;&]", text)]
        return tuple(dict.fromkeys(word for word in parts if word)) or _meant(_ways(plain(text)), told, known)
    first = told.split()
    starts = (" ".join(first[:length]) for length in (3, 2, 1) if len(first) >= length)
    return next(((word,) for start in starts if (word := said.get(start) or _known(start, known))), ())


def _known(text: str, known: Sequence[str]) -> str | None:
    bare = plain(text).replace(" ", "").upper()
    if bare in known:
        return bare
    word = guideword_of(text)
    return word if word in known else None


def parameter_name(text: str, taken: Iterable[str]) -> str:
    """A name that a parameter can have, after a text of any language; one of its own.

    >>> parameter_name("Obstacle detection (front)", ["x"]), parameter_name("障碍", []), parameter_name("x", ["x"])
    ('obstacle_detection_front', 'parameter', 'x_2')
    """
    bare = re.sub(r"[^a-z0-9]+", "_", plain(text).encode("ascii", "ignore").decode()).strip("_")
    name = re.sub(r"^[0-9_]+", "", bare)[:40].strip("_") or "parameter"
    return next(one for k in range(1, MOST_ROWS) if (one := name if k == 1 else f"{name}_{k}") not in set(taken))


@dataclass
class Draft:
    """What the rows of a sheet say of a cell that the study lacks, or has with nothing but its status to do.

    Attributes:
        guideword, parameter: of the cell.
        texts: by key of `HEADS`, each different text once.
        places: of the rows.
    """

    guideword: str
    parameter: str
    texts: dict[str, list[str]] = field(default_factory=dict)
    places: list[str] = field(default_factory=list)

    def add(self, line: Line) -> None:
        """Take what a row says."""
        self.places.append(line.place)
        for key in SAID:
            held = self.texts.setdefault(key, [])
            each = re.split(r"\s*;\s*" if key in LISTS else r"\Z", line.texts.get(key, ""))
            held += (one for one in each if one and one not in held)

    def told(self, key: str) -> str:
        """The texts of a key in one."""
        return "; ".join(self.texts.get(key, ()))


@dataclass(frozen=True)
class RowOf:
    """What a row is about.

    Attributes:
        place: sheet and row.
        cell: the cell; empty: none.
        why: why it is in no draft; empty: it is in one.
    """

    place: str
    cell: str
    why: str = ""


@dataclass(frozen=True)
class Sorted:
    """A sheet beside a study.

    Attributes:
        rows: what each row is about.
        drafts: cells that the study lacks or has bare, by name.
        parameters: node, design intent and title of each parameter that the study lacks, by name.
        words: the guidewords of the drafts that the study lacks.
    """

    rows: tuple[RowOf, ...]
    drafts: Mapping[str, Draft]
    parameters: Mapping[str, Mapping[str, str]]
    words: tuple[str, ...]


def sort(
    lines: Sequence[Line],
    matrix: Matrix,
    words: Mapping[str, str],
    parameters: Mapping[str, str],
    further: Sequence[str] = (),
) -> Sorted:
    """Find for each row the cell that it is about.

    Args:
        lines: rows of a sheet.
        matrix: of the study.
        words: guidewords by texts of the sheet, as the user says.
        parameters: parameters by texts of the sheet, as the user says; the study may lack them.
        further: guidewords that the study lacks and may get.

    Raises:
        InputError: no row has a text that the user names.
    """
    known = list(dict.fromkeys((*(word.id for word in matrix.guidewords), *further)))
    own = {plain(text): name for text, name in parameters.items()}
    there = {plain(text): one.id for one in reversed(matrix.parameters) for text in (one.title, one.id)}
    titles = sorted((*own, *(plain(one.title) for one in matrix.parameters)), key=len, reverse=True)
    names, new = dict[tuple[str, str], str](), dict[str, dict[str, str]]()
    rows, drafts, abouts = list[RowOf](), dict[str, Draft](), dict[str, str]()
    for line in lines:
        node, text = line.texts.get("node", ""), line.texts.get("parameter", "")
        cell, chosen = line.texts.get("cell", ""), named_words(line, words, known)
        about, told = text or node, line.texts.get("deviation", "")
        if not about and (title := next((one for one in titles if f" {one} " in f" {plain(told)} "), "")):
            rest = " ".join(f" {plain(told)} ".replace(f" {title} ", " ", 1).split())
            about, chosen = title, chosen or tuple(filter(None, [_known(rest, known)]))
        about = about or _deviating(told, words)
        abouts |= {plain(about): about} if about else {}
        if cell in matrix:
            rows.append(_row(line, matrix.cell(cell), matrix, drafts))
        elif plain(told) in _NOTHING:
            rows.append(RowOf(line.place, "", f"its deviation says that there is none: {told}"))
        elif not about:
            rows.append(RowOf(line.place, "", "it names no node and no parameter: --column parameter=HEAD"))
        elif not chosen:
            said = line.texts.get("guideword") or " or ".join(line.words)
            why = f"{shown(said)} is not one guideword" if said else "it names no guideword"
            rows.append(RowOf(line.place, "", f"{why}: --guideword TEXT=WORD"))
        else:
            parameter = own.get(plain(about)) or there.get(plain(about)) or names.get((plain(node), plain(about)))
            if parameter is None:
                parameter = parameter_name(about, {*there.values(), *own.values(), *new})
                names[plain(node), plain(about)] = parameter
            for word in chosen:
                rows.append(_row(line, Cell(word, parameter, CellStatus.TO_DO), matrix, drafts))
                given = {"title": about, "node": node or about, "intent": line.texts.get("intent", "")}
                new.setdefault(parameter, given)
    _check_asked(lines, abouts, words, parameters)
    lacking = dict.fromkeys(draft.guideword for draft in drafts.values())
    return Sorted(
        tuple(rows),
        drafts,
        {name: said for name, said in new.items() if name not in {one.id for one in matrix.parameters}},
        tuple(word for word in lacking if word not in {one.id for one in matrix.guidewords}),
    )


def _deviating(deviation: str, own: Mapping[str, str]) -> str:
    """What deviates, of a deviation that begins with a guideword: of `No flow` the flow."""
    told, said = deviation.split(), set(map(plain, own))
    for length in (3, 2, 1):
        start = " ".join(told[:length])
        if len(told) > length and (guideword_of(start) or plain(start) in said):
            return " ".join(told[length:])
    return ""


def _row(line: Line, cell: Cell, matrix: Matrix, drafts: dict[str, Draft]) -> RowOf:
    """What becomes of a row about a cell: it is drafted where the study lacks the cell, or has nothing of it."""
    said = [key for key in SAID if line.texts.get(key)]
    known = matrix.cell(cell.name) if cell.name in matrix else None
    severity = matrix.severities.get(cell.name)
    if known is None or (known.bare and severity is None and said):
        drafts.setdefault(cell.name, Draft(cell.guideword, cell.parameter)).add(line)
        return RowOf(line.place, cell.name)
    own = severity.id if severity else known.drafted
    held = {**vars(known.team), **vars(known), "causes": "; ".join(known.causes), "severity": own}
    other = ", ".join(key for key in said if f"; {line.texts[key]}; " not in f"; {held[key]}; ")
    differs = f"; the sheet's text differs, and is not taken: {other}" if other else ""
    return RowOf(line.place, cell.name, f"the study has this cell{differs}")


def _check_asked(
    lines: Sequence[Line], abouts: Mapping[str, str], words: Mapping[str, str], parameters: Mapping[str, str]
) -> None:
    """Refuse a text of the user that no row has, as a guideword or as what it is about."""
    told = dict[str, str]()
    for text in (line.texts.get("guideword", "") for line in lines):
        told |= {plain(one): one.strip() for one in (text, *re.split(r"[/,;&]", text)) if one.strip()}
    deviations = [f" {plain(line.texts.get('deviation', ''))} " for line in lines if "guideword" not in line.texts]
    for text, word in words.items():
        if plain(text) not in told and not any(one.startswith(f" {plain(text)} ") for one in deviations):
            raise InputError(f"--guideword={f'{text}={word}'!r}: no row has {text!r}{nearest(text, told.values())}")
    for text, name in parameters.items():
        if plain(text) not in abouts:
            hint = nearest(text, abouts.values())
            raise InputError(f"--parameter={f'{text}={name}'!r}: no row is about {text!r}{hint}")
