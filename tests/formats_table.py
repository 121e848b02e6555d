"""The tables of docs/formats.md, made from the formats and from the kinds of files that are tried.

``python -m tests.formats_table`` brings the page up to date; a test holds that it is.
"""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

from poisson_cli.images import formats

PAGE = Path(__file__).resolve().parent.parent / "docs" / "formats.md"
BEGIN, END = "<!-- tables: made by python -m tests.formats_table -->\n", "<!-- end of tables -->"
DEPTHS = {"8": "8 bits", "16": "16 bits", "float": "floats"}
LABELS = {"profile": "ICC profile", "exif": "EXIF", "xmp": "XMP", "dpi": "dpi", "iptc": "IPTC"}


def written() -> str:
    rows = ["| format | endings | depths | alpha | goes along | without loss |", "|---|---|---|---|---|---|"]
    rows += [
        f"| {form.name} | {' '.join(form.extensions)} | {', '.join(DEPTHS[depth] for depth in form.depths)} | "
        f"{'yes' if form.alpha else 'no'} | {', '.join(LABELS[kind] for kind in form.carries) or 'nothing'} | "
        f"{'yes' if form.exact else 'no'} |"
        for form in formats.WRITTEN
    ]
    return "\n".join(rows)


def read() -> str:
    from tests.kinds import KINDS

    rows = ["| format | kinds that are tried |", "|---|---|"]
    for form, names in groupby(KINDS, key=lambda name: name.partition(", ")[0]):
        kinds = [name.partition(", ")[2] for name in names]
        rows.append(f"| {form} | {'; '.join(kind or 'all' for kind in kinds)} |")
    return "\n".join(rows)


def with_tables(page: str) -> str:
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    tables = f"## Written\n\n{written()}\n\n## Read\n\n{read()}\n\n"
    return f"{before}{BEGIN}\n{tables}{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(with_tables(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
