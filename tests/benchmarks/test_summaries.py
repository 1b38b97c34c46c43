"""Means and counts of the benchmarks' rows."""

from benchmarks.summaries import MEASURES, counts_of_right, means


def test_rows_with_an_error_count_among_all_but_not_in_means():
    good = {**dict.fromkeys(MEASURES, 1.0), "is_topology_right": True, "n_tips": 3, "n_true_tips": 3}
    other = {**dict.fromkeys(MEASURES, 2.0), "is_topology_right": True, "n_tips": 2, "n_true_tips": 3}
    rows = [good, other, {"error": "no edges"}]
    assert means(rows) == dict.fromkeys(MEASURES, 1.5)
    assert counts_of_right(rows) == {"topology right": "2/3", "tips right": "1/3"}
    assert means(rows[2:]) == dict.fromkeys(MEASURES)
