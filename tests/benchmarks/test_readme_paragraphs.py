"""Paragraphs of README.md from the results; that README.md has them is in ``tests/test_readme.py``."""

import json
import shutil

import pytest

from benchmarks.provenance import ROOT
from benchmarks.readme_paragraphs import PARAGRAPHS, WIDTH, _bound, paragraph

RESULTS = ROOT / "benchmarks" / "results"


@pytest.mark.parametrize("name", PARAGRAPHS)
def test_every_figure_is_filled_in(name):
    text = paragraph(name, RESULTS)
    assert not {"{", "}"} & set(text)
    assert not {"nan", "None"} & set(text.replace(",", " ").split())
    assert max(map(len, text.splitlines())) <= WIDTH


@pytest.mark.parametrize(("value", "digits", "told"), [(0.2242, 2, "0.23"), (0.05, 2, "0.05"), (3.001, 0, "4")])
def test_a_bound_is_rounded_up(value, digits, told):
    assert _bound([0.0, value], digits) == told


def test_a_figure_is_that_of_the_result(tmp_path):
    shutil.copy(RESULTS / "interrupts.json", tmp_path)
    document = json.loads((tmp_path / "interrupts.json").read_text(encoding="utf-8"))
    document["interrupts"][0] |= {"faces": 12_345, "longest wait": 7.0}
    (tmp_path / "interrupts.json").write_text(json.dumps(document), encoding="utf-8")
    assert "of 12,345 faces within 7.00 s in Python" in " ".join(paragraph("waits", tmp_path).split())
