"""A picture that a notebook shows and a file keeps."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from scaloft_fi.errors import InputError
from scaloft_fi.output import write_named

ENDS = (".svg", ".png")


@dataclass(frozen=True)
class Figure:
    """A picture.

    Attributes:
        title: what it shows.
        svg: the text of an SVG file.
    """

    title: str
    svg: str

    def save(self, path: Path | str) -> Path:
        """Write the picture; the end of the name decides the format.

        Args:
            path: a name that ends in `.svg` or `.png`.

        Raises:
            InputError: the name ends otherwise, or the file cannot be written.
        """
        from scaloft_fi.views.pictures.picture import png

        file = Path(path)
        end = file.suffix.lower()
        if end not in ENDS:
            raise InputError(f"path={str(path)!r} must end in {' or '.join(ENDS)}")
        write_named(file, png(self.svg) if end == ".png" else self.svg.encode(), "path")
        return file

    def __repr__(self) -> str:
        return f"<figure: {self.title}>"

    def _repr_svg_(self) -> str:
        return self.svg
