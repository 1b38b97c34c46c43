"""Records of a batch: lines of JSON in the manifest for each input as it ends, and a table of all at the end.

Before files are put in their places, a line without a key names them. So a batch that is killed meanwhile is known to
have made them, and makes them again.
"""

from __future__ import annotations

__all__ = [
    "MANIFEST",
    "SUMMARY",
    "BatchStatus",
    "Record",
    "append",
    "hash_of",
    "is_final",
    "known",
    "put_in_place",
    "summary",
    "unwritable",
    "written",
]

import csv
import hashlib
import io
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields, replace
from enum import Enum
from pathlib import Path
from typing import Any

MANIFEST, SUMMARY = "manifest.jsonl", "summary.csv"  # files in the output folder
CHUNK_BYTES = 1 << 20  # read at a time for hashing


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
    verdict : str
        Of its score: pass, warn or fail; empty if there is no skeleton.
    key : str
        Hash of the content of the input and of all options; empty if another run on the same input could end otherwise,
        as after the installation of a package.
    seconds : float
    vertices, faces, nodes, tips, junctions, cycles : int or None
        None if there is no skeleton.
    length : float or None
        Of all branches, in the units of the file.
    inside_fraction : float or None
        Share of the length inside the surface.
    files : tuple of str
        What was written, relative to the output folder.
    """

    input: str
    output: str
    outcome: BatchStatus
    message: str = ""
    verdict: str = ""
    key: str = ""
    seconds: float = 0.0
    vertices: int | None = None
    faces: int | None = None
    nodes: int | None = None
    tips: int | None = None
    junctions: int | None = None
    cycles: int | None = None
    length: float | None = None
    inside_fraction: float | None = None
    files: tuple[str, ...] = ()


def known(folder: Path) -> dict[str, Record]:
    """Read the last record of each output in a folder's manifest."""
    return {record.output: record for record in _read(folder)}


def written(folder: Path) -> set[str]:
    """List the files that batches have written in a folder, by its manifest, with the manifest and the summary."""
    records = _read(folder)
    return {MANIFEST, SUMMARY, *(file for record in records for file in record.files)} if records else set()


def _read(folder: Path) -> list[Record]:
    """Read all records in a folder's manifest; lines that a crash cut short are skipped."""
    try:
        lines = (folder / MANIFEST).read_text(encoding="utf-8", errors="replace").splitlines()
    except FileNotFoundError:
        return []
    records = []
    for line in lines:
        try:
            values = json.loads(line)
            files = tuple(values.get("files", [values["output"]]))  # manifests of 0.1.0 list no files
            records.append(Record(**{**values, "outcome": BatchStatus(values["outcome"]), "files": files}))
        except (ValueError, TypeError, KeyError, AttributeError):
            continue
    return records


def append(folder: Path, record: Record) -> None:
    """Append a record to the manifest on a line of its own, also after a line that was cut short."""
    with open(folder / MANIFEST, "a+b") as file:
        if file.tell() > 0:
            file.seek(-1, io.SEEK_END)
            if file.read(1) != b"\n":
                file.write(b"\n")
        file.write(json.dumps(asdict(record)).encode() + b"\n")


def put_in_place(folder: Path, record: Record, made: str) -> Record:
    """Move the files of an input from the folder where they were made, append its record, and return it.

    Parameters
    ----------
    folder : Path
        The output folder.
    record : Record
        Without its files.
    made : str
        What it holds is moved if there is a skeleton.
    """
    if record.outcome in (BatchStatus.PASSED, BatchStatus.FAILED_CHECKS):
        target = Path(record.output).parent
        paths = {(target / path.name).as_posix(): path for path in sorted(Path(made).iterdir())}
        record = replace(record, files=tuple(paths))
        append(folder, replace(record, key=""))
        try:
            for name, path in paths.items():
                os.replace(path, folder / name)
        except OSError as error:
            record = unwritable(record, error)
    append(folder, record)
    return record


def unwritable(record: Record, error: OSError) -> Record:
    """Return the record of an input whose skeleton cannot be written; another run may write it."""
    reason = f"{error.strerror or error}: {error.filename2 or error.filename}"
    message = f"{record.output} cannot be written: {reason}; move away what is there, or name another folder"
    return Record(record.input, record.output, BatchStatus.REFUSED, message, files=record.files)


def is_final(record: Record | None, key: str, folder: Path) -> bool:
    """Whether a record has the key of this content and these options, is final, and its files still exist."""
    if record is None or record.key != key or record.outcome not in FINAL:
        return False
    return all((folder / file).is_file() for file in record.files)


def hash_of(parameters: Mapping[str, Any], files: Iterable[Path]) -> str:
    """Hash parameters and the contents of files."""
    digest = hashlib.sha256(json.dumps(parameters, sort_keys=True).encode())
    for path in files:
        with open(path, "rb") as file:
            while chunk := file.read(CHUNK_BYTES):
                digest.update(chunk)
    return digest.hexdigest()


def summary(records: Iterable[Record]) -> str:
    """Format the records as CSV, one row each."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(field.name for field in fields(Record))
    rows.writerows(
        {**asdict(record), "outcome": record.outcome.value, "files": " ".join(record.files)}.values()
        for record in records
    )
    return text.getvalue()
