"""Reports as HTML pages that need nothing from outside: headings, words, tables and drawings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Final

STYLE: Final = """
body { font: 15px/1.45 system-ui, sans-serif; color: #222; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; } h2 { margin-top: 2.6rem; border-bottom: 1px solid #ccc; } h3 { margin: 2rem 0 .2rem; }
table { border-collapse: collapse; font-size: .86rem; font-variant-numeric: tabular-nums; margin: .6rem 0; }
th, td { padding: .12rem .7rem .12rem 0; text-align: right; border-bottom: 1px solid #eee; }
th { color: #555; font-weight: 600; } th:first-child, td:first-child { text-align: left; }
tr.bad td { color: #b00020; font-weight: 600; } .good { color: #1b6e2c; } .bad { color: #b00020; }
svg { width: 100%; max-width: 760px; height: auto; display: block; margin: .4rem 0; }
p { margin: .4rem 0; } .small { color: #555; font-size: .86rem; } details { margin: .3rem 0; }
@media print { details { display: block; } }
"""


@dataclass(frozen=True)
class Words:
    """A paragraph; kind: "", "small", "good" or "bad"."""

    text: str
    kind: str = ""

    def html(self) -> str:
        """As an element."""
        return f'<p class="{self.kind}">{escape(self.text)}</p>' if self.kind else f"<p>{escape(self.text)}</p>"


@dataclass(frozen=True)
class Table:
    """Rows of text; bad: numbers of the rows to stand out; links: targets of the first cells, "" for none."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    bad: frozenset[int] = frozenset()
    links: tuple[str, ...] = ()

    def html(self) -> str:
        """As an element."""
        lines = ["<table>", "<tr>" + "".join(f"<th>{escape(cell)}</th>" for cell in self.head) + "</tr>"]
        for number, row in enumerate(self.rows):
            cells = [escape(cell) for cell in row]
            if self.links and self.links[number]:
                cells[0] = f'<a href="#{escape(self.links[number])}">{cells[0]}</a>'
            opening = '<tr class="bad">' if number in self.bad else "<tr>"
            lines.append(opening + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
        return "\n".join([*lines, "</table>"])


@dataclass(frozen=True)
class Folded:
    """A table that opens when it is asked for."""

    title: str
    table: Table
    opened: bool = False

    def html(self) -> str:
        """As an element."""
        start = '<details open="open">' if self.opened else "<details>"
        return f"{start}<summary>{escape(self.title)}</summary>\n{self.table.html()}\n</details>"


@dataclass(frozen=True)
class Drawing:
    """An ``<svg>`` element."""

    svg: str

    def html(self) -> str:
        """As it is."""
        return self.svg


@dataclass(frozen=True)
class Heading:
    """A heading of level 2 or 3; anchor: what links name it by."""

    text: str
    level: int = 2
    anchor: str = ""

    def html(self) -> str:
        """As an element."""
        name = f' id="{escape(self.anchor)}"' if self.anchor else ""
        return f"<h{self.level}{name}>{escape(self.text)}</h{self.level}>"


Block = Words | Table | Folded | Drawing | Heading


def page(title: str, blocks: Sequence[Block]) -> str:
    """A whole HTML page."""
    return "\n".join(
        [
            "<!DOCTYPE html>",
            '<html lang="en"><head><meta charset="utf-8"/>',
            '<meta name="viewport" content="width=device-width, initial-scale=1"/>',
            f"<title>{escape(title)}</title><style>{STYLE}</style></head><body>",
            f"<h1>{escape(title)}</h1>",
            *(block.html() for block in blocks),
            "</body></html>",
            "",
        ]
    )
