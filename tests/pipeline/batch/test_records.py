"""Records: the manifest survives crashes, and says which inputs are done."""

import csv
import io
import json
from dataclasses import fields, replace

from lbskel.pipeline.batch.records import (
    MANIFEST,
    SUMMARY,
    BatchStatus,
    Record,
    append,
    hash_of,
    is_final,
    known,
    summary,
    written,
)

DONE = Record("a.ply", "a.json", BatchStatus.PASSED, key="k", seconds=1.5, nodes=7, files=("a.json", "a.png"))


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


def test_files_of_all_records_count_as_written_with_those_of_the_folder(tmp_path):
    assert written(tmp_path) == set()
    (tmp_path / MANIFEST).write_bytes(b'[1, "of the user"]\n\xff\n')
    assert written(tmp_path) == set()
    append(tmp_path, DONE)
    append(tmp_path, replace(DONE, outcome=BatchStatus.REFUSED, files=()))
    assert written(tmp_path) == {MANIFEST, SUMMARY, "a.json", "a.png"}
    old = {"input": "b.ply", "output": "b.json", "outcome": "passed"}  # as written by 0.1.0
    with open(tmp_path / MANIFEST, "a") as manifest:
        manifest.write(json.dumps(old) + "\n")
    assert written(tmp_path) == {MANIFEST, SUMMARY, "a.json", "a.png", "b.json"}


def test_a_record_is_final_with_the_same_key_and_existing_files(tmp_path):
    (tmp_path / "a.json").write_text("{}")
    assert not is_final(DONE, "k", tmp_path)  # its picture is missing
    (tmp_path / "a.png").write_bytes(b"")
    assert is_final(DONE, "k", tmp_path)
    assert not is_final(DONE, "other", tmp_path)
    assert not is_final(None, "k", tmp_path)
    assert not is_final(replace(DONE, outcome=BatchStatus.OVER_TIME), "k", tmp_path)
    assert is_final(replace(DONE, outcome=BatchStatus.REFUSED, files=()), "k", tmp_path)


def test_the_summary_has_a_row_for_each(tmp_path):
    rows = list(csv.DictReader(io.StringIO(summary([DONE, replace(DONE, output="b.json", nodes=None)]))))
    assert list(rows[0]) == [field.name for field in fields(Record)]
    assert [(row["output"], row["outcome"], row["nodes"], row["files"]) for row in rows] == [
        ("a.json", "passed", "7", "a.json a.png"),
        ("b.json", "passed", "", "a.json a.png"),
    ]


def test_a_hash_depends_on_parameters_and_on_all_contents(tmp_path):
    a, b = tmp_path / "a", tmp_path / "b"
    a.write_bytes(b"1")
    b.write_bytes(b"2")
    first = hash_of({"x": 1}, [a, b])
    assert hash_of({"x": 1}, [a, b]) == first
    assert hash_of({"x": 2}, [a, b]) != first
    b.write_bytes(b"3")
    assert hash_of({"x": 1}, [a, b]) != first
