"""One self-contained HTML document: its head, style and content security policy; tables and pictures.

All text is escaped. The policy (https://www.w3.org/TR/CSP3/) forbids every connection, and every script but those whose
hashes it names, so that nothing is downloaded and no name or note can run; those scripts may use eval.
"""

from __future__ import annotations

__all__ = ["Table", "cell", "document", "image", "paragraphs", "script", "table"]

import base64
import hashlib
import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from html import escape
from importlib.resources import files
from typing import Any


@dataclass(frozen=True)
class Table:
    """A table of a page.

    Parameters
    ----------
    caption : str
    head : sequence of str
        Headings of the columns.
    rows : sequence of sequences
        Values; the first of each row is its heading. True and False are written yes and no, None as a dash.
    kinds : sequence of str, optional
        For each row ``pass``, ``warn`` or ``fail``, which colors it, or an empty text.
    """

    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[Any]]
    kinds: Sequence[str] = ()


def document(
    title: str,
    body: str,
    *,
    scripts: Sequence[str] = (),
    held: Sequence[str] = (),
    data: Mapping[str, Any] | None = None,
) -> bytes:
    """Compose a document.

    Parameters
    ----------
    title : str
        Of the window and the first heading.
    body : str
        HTML, in which all text is escaped.
    scripts : sequence of str
        Programs that run in this order when the page is read.
    held : sequence of str
        Programs that are packed by zlib; one of ``scripts`` has to unpack and run them.
    data : mapping, optional
        The content of the element ``data``, which the programs read; ready for JSON, and packed too.
    """
    hashes = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in (*scripts, *held)]
    allowed = " ".join(["'unsafe-eval'", *(f"'sha256-{each}'" for each in hashes)]) if scripts else "'none'"
    policy = (
        f"default-src 'none'; form-action 'none'; img-src data: blob:; style-src 'unsafe-inline'; script-src {allowed}"
    )
    parts = [
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(title)}</title>\n<style>\n{_resource('page.css')}</style></head><body>",
        f"<main>\n<h1>{escape(title)}</h1>\n{body}\n</main>",
    ]
    if data is not None:
        text = json.dumps(data, separators=(",", ":"), allow_nan=False)
        parts.append(f'<script type="application/json" id="data" data-packed>{_packed(text)}</script>')
    parts.extend(f'<script type="text/plain" data-packed>{_packed(script)}</script>' for script in held)
    parts.extend(f"<script>{script}</script>" for script in scripts)
    return "\n".join([*parts, "</body></html>\n"]).encode("utf-8", errors="replace")


def table(content: Table) -> str:
    """Write a table as HTML; it scrolls where the page is narrower."""
    is_prose = [any(isinstance(row[k], str) for row in content.rows) for k in range(len(content.head))]
    classes = [' class="prose"' if is_text else "" for is_text in is_prose]
    head = "".join(
        f'<th scope="col"{mark}>{escape(name)}</th>' for name, mark in zip(content.head, classes, strict=True)
    )
    rows = []
    for number, (first, *others) in enumerate(content.rows):
        kind = content.kinds[number] if content.kinds else ""
        cells = "".join(
            f"<td{look}>{escape(cell(value))}</td>" for value, look in zip(others, classes[1:], strict=True)
        )
        mark = f' class="{escape(kind)}"' if kind else ""
        rows.append(f'<tr{mark}><th scope="row">{escape(cell(first))}</th>{cells}</tr>')
    caption = f"<caption>{escape(content.caption)}</caption>"
    lines = "\n".join(rows)
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(content.caption)}"><table>{caption}'
        f"<thead><tr>{head}</tr></thead>\n<tbody>\n{lines}\n</tbody></table></div>"
    )


def cell(value: Any) -> str:
    """Format a value of a table."""
    if value is None or value != value:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}"
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def image(png: bytes, description: str) -> str:
    """Write a picture as HTML, with its bytes."""
    return f'<img src="data:image/png;base64,{base64.b64encode(png).decode()}" alt="{escape(description)}">'


def paragraphs(texts: Sequence[str]) -> str:
    """Write sentences as HTML, a paragraph each."""
    return "\n".join(f"<p>{escape(text)}</p>" for text in texts)


def script(name: str) -> str:
    """Read a program of this package."""
    return _resource(name)


@lru_cache(maxsize=3)  # the two programs, which are the same in each page, and its data
def _packed(text: str) -> str:
    """Compress text, and write it in letters; plotly.js takes two fifths of its size."""
    return base64.b64encode(zlib.compress(text.encode())).decode()


def _resource(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")
