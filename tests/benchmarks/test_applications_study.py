"""The page on operators: the best ones by column, those nearly as good, and those that refuse."""

from benchmarks.applications_study import table


def test_the_best_the_worst_and_those_that_refuse_are_named():
    rows = [
        {"operator": "`cotangent`", "good": 0.1, "bad": 0.5},
        {"operator": "`robust`", "good": 0.101, "bad": 0.2},
        {"operator": "`graph`", "good": 0.9, "bad": "not symmetric"},
    ]
    good, bad = table(rows)
    assert good["by"] == "`cotangent`, `robust`"
    assert good["largest error"] == "`graph` 0.9"
    assert good["refused"] == "none"
    assert (bad["smallest error"], bad["by"], bad["refused"]) == (0.2, "`robust`", "`graph`")
    assert bad["`cotangent`"] == 0.5


def test_errors_of_rounding_are_equally_good():
    rows = [{"operator": "`cotangent`", "drift": 8e-16}, {"operator": "`robust`", "drift": 3e-15}]
    rows.append({"operator": "`graph`", "drift": 0.1})
    assert table(rows)[0]["by"] == "`cotangent`, `robust`"
