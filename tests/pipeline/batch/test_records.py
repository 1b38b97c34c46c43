"""Records: the manifest survives crashes, and says which inputs are done."""

import csv
import io
from dataclasses import fields, replace

from lbskel.pipeline.batch.records import MANIFEST, BatchStatus, Record, append, is_final, known, summary

DONE = Record("a.ply", "a.json", BatchStatus.PASSED, key="k", seconds=1.5, nodes=7)


def test_the_last_record_of_an_output_counts(tmp_path):
    append(tmp_path, replace(DONE, outcome=BatchStatus.OVER_TIME))
    append(tmp_path, DONE)
    append(tmp_path, replace(DONE, output="b.json"))
    assert known(tmp_path) == {"a.json": DONE, "b.json": replace(DONE, output="b.json")}


def test_a_line_that_was_cut_short_is_skipped_and_the_next_one_is_whole(tmp_path):
    append(tmp_path, DONE)
    text = (tmp_path / MANIFEST).read_text()
    (tmp_path / MANIFEST).write_text(text + text[: len(text) // 2])
    append(tmp_path, replace(DONE, output="b.json"))
    assert list(known(tmp_path)) == ["a.json", "b.json"]


def test_no_manifest_knows_nothing(tmp_path):
    assert known(tmp_path) == {}


def test_a_record_is_final_with_the_same_key_and_an_existing_skeleton(tmp_path):
    assert not is_final(DONE, "k", tmp_path)  # its skeleton is missing
    (tmp_path / "a.json").write_text("{}")
    assert is_final(DONE, "k", tmp_path)
    assert not is_final(DONE, "other", tmp_path)
    assert not is_final(None, "k", tmp_path)
    assert not is_final(replace(DONE, outcome=BatchStatus.OVER_TIME), "k", tmp_path)
    assert is_final(replace(DONE, outcome=BatchStatus.REFUSED, output="none.json"), "k", tmp_path)


def test_the_summary_has_a_row_for_each(tmp_path):
    rows = list(csv.DictReader(io.StringIO(summary([DONE, replace(DONE, output="b.json", nodes=None)]))))
    assert list(rows[0]) == [field.name for field in fields(Record)]
    assert [(row["output"], row["outcome"], row["nodes"]) for row in rows] == [
        ("a.json", "passed", "7"),
        ("b.json", "passed", ""),
    ]
