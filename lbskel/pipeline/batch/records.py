"""Records of a batch: a line of JSON in the manifest for each input as it ends, and a table of all at the end."""

from __future__ import annotations

__all__ = ["MANIFEST", "SUMMARY", "BatchStatus", "Record", "append", "known", "summary"]

import csv
import io
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from enum import Enum
from pathlib import Path

MANIFEST, SUMMARY = "manifest.jsonl", "summary.csv"  # files in the output folder


class BatchStatus(str, Enum):
    """How the work on one input ended."""

    PASSED = "passed"
    FAILED_CHECKS = "failed its checks"
    REFUSED = "refused"
    OVER_TIME = "over time"
    OVER_MEMORY = "over memory"
    ENDED = "process ended"


FINAL = (
    BatchStatus.PASSED,
    BatchStatus.FAILED_CHECKS,
    BatchStatus.REFUSED,
)  # a second run would end the same way


@dataclass(frozen=True)
class Record:
    """One input of a batch.

    Parameters
    ----------
    input, output : str
        Path of the mesh as the caller named it, and of the skeleton relative to the output folder.
    outcome : BatchStatus
    message : str
        Why there is no skeleton, or which measures of its score fail and which cycles were cut.
    key : str
        Hash of the content of the input and of all options; empty if the input could not be read.
    seconds : float
    vertices, faces, nodes, tips, junctions, cycles : int or None
        None if there is no skeleton.
    inside_fraction : float or None
        Share of the length inside the surface.
    """

    input: str
    output: str
    outcome: BatchStatus
    message: str = ""
    key: str = ""
    seconds: float = 0.0
    vertices: int | None = None
    faces: int | None = None
    nodes: int | None = None
    tips: int | None = None
    junctions: int | None = None
    cycles: int | None = None
    inside_fraction: float | None = None


def known(folder: Path) -> dict[str, Record]:
    """Read the last record of each output in a folder's manifest; lines that a crash cut short are skipped."""
    try:
        lines = (folder / MANIFEST).read_text(encoding="utf-8").splitlines()
    except FileNotFoundError:
        return {}
    records = {}
    for line in lines:
        try:
            values = json.loads(line)
            record = Record(**{**values, "outcome": BatchStatus(values["outcome"])})
        except (ValueError, TypeError, KeyError):
            continue
        records[record.output] = record
    return records


def append(folder: Path, record: Record) -> None:
    """Append a record to the manifest on a line of its own, also after a line that was cut short."""
    with open(folder / MANIFEST, "a+b") as file:
        if file.tell() > 0:
            file.seek(-1, io.SEEK_END)
            if file.read(1) != b"\n":
                file.write(b"\n")
        file.write(json.dumps(asdict(record)).encode() + b"\n")


def is_final(record: Record | None, key: str, folder: Path) -> bool:
    """Whether a record has the key of this content and these options, is final, and any skeleton still exists."""
    if record is None or record.key != key or record.outcome not in FINAL:
        return False
    return record.outcome is BatchStatus.REFUSED or (folder / record.output).is_file()


def summary(records: Iterable[Record]) -> str:
    """Format the records as CSV, one row each."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(field.name for field in fields(Record))
    rows.writerows(
        [value.value if isinstance(value, BatchStatus) else value for value in asdict(record).values()]
        for record in records
    )
    return text.getvalue()
