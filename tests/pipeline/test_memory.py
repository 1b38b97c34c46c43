"""The memory that a run takes: the estimate, the limit, and what is done about it."""

import pytest

from lbskel import MemoryLimitError, UnknownChoice, skeletonize
from lbskel.pipeline import memory
from lbskel.pipeline.memory import free_megabytes, megabytes_needed, simplify_within
from lbskel.shapes import torus


@pytest.mark.parametrize(
    ("n_faces", "simplify", "measured", "margin"),
    [
        (489_312, "auto", 692, 0.05),
        (489_312, "none", 824, 0.05),
        (1_957_248, "auto", 2231, 0.15),
        (1_957_248, "none", 2752, 0.15),
        (5_000_000, "auto", 3750, 0.7),
        (5_000_000, "none", 5720, 0.7),
    ],
)
def test_the_estimate_is_what_was_measured_or_more(n_faces, simplify, measured, margin):
    """In benchmarks/results/proxies.md of thin shapes, and in speed.md of a thick one, which takes less."""
    assert 0.98 * measured <= megabytes_needed(n_faces, simplify) <= (1 + margin) * measured


def test_a_mesh_over_the_limit_is_refused_before_it_is_prepared(monkeypatch):
    monkeypatch.setattr("lbskel.pipeline.stages.prepare", None)
    with pytest.raises(MemoryLimitError, match=r"about 113 MB of memory, and the limit is 50: simplify it first"):
        skeletonize(torus(1.0, 0.3), memory_limit=50)
    monkeypatch.setattr(memory, "free_megabytes", lambda: 20.0)
    with pytest.raises(MemoryLimitError, match="the limit is 20"):
        skeletonize(torus(1.0, 0.3))
    with pytest.raises(UnknownChoice, match="memory_limit must be a positive number of megabytes, not 0"):
        skeletonize(torus(1.0, 0.3), memory_limit=0)


def test_a_mesh_too_large_to_contract_in_full_is_contracted_by_a_proxy():
    ring = torus(1.0, 0.3)
    limit = (megabytes_needed(len(ring.faces), "auto") + megabytes_needed(len(ring.faces), "none")) / 2
    assert simplify_within(ring, "auto", limit) == ("auto", [])
    report = skeletonize(ring, simplify="none", memory_limit=limit).report
    assert [note for note in report["notes"] if note.startswith("contracted by a proxy, since in full")]
    assert simplify_within(ring, "none", 1000.0) == ("none", [])


def test_what_is_free_is_what_the_system_says(monkeypatch, tmp_path):
    account = tmp_path / "meminfo"
    account.write_text("MemTotal:  2000000 kB\nMemAvailable:  1000000 kB\n")
    monkeypatch.setattr(memory, "MEMORY_INFO", account)
    assert free_megabytes() == pytest.approx(1024)
    account.write_text("MemTotal:  2000000 kB\n")
    assert free_megabytes() == float("inf")
    monkeypatch.setattr(memory, "MEMORY_INFO", tmp_path / "none")
    assert free_megabytes() == float("inf")
