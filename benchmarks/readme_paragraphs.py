"""Paragraphs of README.md whose figures come from the results: a text for each, and a function that gives them."""

from __future__ import annotations

__all__ = ["PARAGRAPHS", "WIDTH", "paragraph"]

import re
import textwrap
from pathlib import Path

from benchmarks import readme_applications, readme_installation, readme_skeletons, readme_verdicts

WIDTH = 125  # characters of a line, as in the rest of README.md
PARAGRAPHS = {
    **readme_installation.PARAGRAPHS,
    **readme_applications.PARAGRAPHS,
    **readme_skeletons.PARAGRAPHS,
    **readme_verdicts.PARAGRAPHS,
}


def paragraph(name: str, results: Path) -> str:
    """Return a paragraph, or the items of a list, with the figures, in lines.

    Raises
    ------
    ValueError
        If the results do not bear out what it says.
    """
    text, figures = PARAGRAPHS[name]
    items = re.split(r"\n(?=- )", text.format(**figures(results)).strip())
    return "".join(_lines(item) for item in items)


def _lines(text: str) -> str:
    indent = "  " if text.startswith("- ") else ""
    words = " ".join(text.split())
    return textwrap.fill(words, WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False) + "\n"
