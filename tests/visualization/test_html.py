"""HTML documents: what they may load and run, and that text stays text."""

import base64
import hashlib
import json
import re
from html.parser import HTMLParser

import pytest
from helpers import inflated

from lbskel.visualization import html
from lbskel.visualization.html import Table, cell, document, image, paragraphs, table

HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)>\"'&"


class Elements(HTMLParser):
    """The elements of a document, and the text of each script."""

    def __init__(self, content):
        super().__init__()
        self.tags, self.text = [], ""
        scripts = re.findall(r"<script([^>]*)>(.*?)</script>", content.decode(), re.S)
        self.scripts = [inflated(text) if "data-packed" in attributes else text for attributes, text in scripts]
        self.feed(content.decode())

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))

    def handle_data(self, data):
        self.text += data

    def named(self, tag):
        return [attributes for name, attributes in self.tags if name == tag]


def test_hostile_text_is_shown_as_text_everywhere():
    content = Table(HOSTILE, ["", HOSTILE], [[HOSTILE, HOSTILE]], [HOSTILE])
    body = table(content) + paragraphs([HOSTILE]) + image(b"png", HOSTILE)
    found = Elements(document(HOSTILE, body, data={"name": HOSTILE}))
    assert len(found.named("script")) == 1
    assert len(found.named("img")) == 1
    assert not [name for _, attributes in found.tags for name in attributes if name.startswith("on")]
    assert found.text.count(HOSTILE) == 7  # title, heading, caption, column, row, cell, paragraph
    assert json.loads(found.scripts[0])["name"] == HOSTILE
    assert found.named("img")[0]["alt"] == HOSTILE


def test_the_policy_names_the_programs_and_forbids_all_else():
    found = Elements(document("t", "", scripts=["let a = 1;"], held=["let b = 2;"]))
    (policy,) = (each["content"] for each in found.named("meta") if each.get("http-equiv"))
    hashes = re.findall(r"'sha256-([^']+)'", policy)
    expected = [base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in reversed(found.scripts)]
    assert hashes == expected
    assert found.named("script") == [{"type": "text/plain", "data-packed": None}, {}]
    assert len(hashes) == 2
    assert policy.startswith("default-src 'none'; ")
    assert "'unsafe-inline'" not in policy.partition("script-src")[2]
    plain = document("t", "")
    assert b"script-src 'none'" in plain
    assert b"<script" not in plain


def test_text_that_is_no_unicode_has_a_document():
    assert b"<h1>a?.off</h1>" in document("a\udcff.off", "")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "-"),
        (float("nan"), "-"),
        (True, "yes"),
        (False, "no"),
        (1234567, "1,234,567"),
        (0.12345, "0.123"),
        ("x", "x"),
    ],
)
def test_values_of_cells(value, text):
    assert cell(value) == text


def test_rows_have_headings_and_kinds():
    found = Elements(table(Table("c", ["a", "b"], [["r", 1], ["s", 2]], ["", "fail"])).encode())
    assert [each.get("scope") for each in found.named("th")] == ["col", "col", "row", "row"]
    assert [each.get("class") for each in found.named("tr")] == [None, None, "fail"]


def test_columns_with_words_are_left_aligned():
    """By their class, in which page.css aligns text to the left."""
    written = table(Table("a", ["name", "value", "meaning"], [["b", 1.0, "c"], ["d", None, None]]))
    assert '<th scope="col">value</th><th scope="col" class="prose">meaning</th>' in written
    assert '<td>1</td><td class="prose">c</td>' in written
    assert '<td>-</td><td class="prose">-</td>' in written


def test_the_programs_of_a_page_are_compressed_once():
    html._packed.cache_clear()
    for number in range(4):
        for text in (f"data {number}", "plotly.js", "page.js"):
            html._packed(text)
    assert html._packed.cache_info().misses == 4 + 2
