"""The gallery: every example runs, holds what it claims and has a picture; the committed page shows them all."""

import io

import numpy as np
import pytest
from PIL import Image

from benchmarks.gallery import EXAMPLES, HERE, run, run_example


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_and_draws_its_picture(path, tmp_path):
    picture, _ = run_example(path, tmp_path)
    with Image.open(io.BytesIO(picture)) as image:
        pixels = np.asarray(image.convert("L"))
    assert (pixels < 240).mean() > 0.01
    assert len(picture) < 150_000
    assert "assert " in path.read_text()


def test_an_example_that_does_not_hold_fails(tmp_path):
    (tmp_path / "wrong.py").write_text('"""Wrong."""\n\nassert 1 == 2\n')
    with pytest.raises(AssertionError):
        run_example(tmp_path / "wrong.py", tmp_path)


def test_the_page_shows_every_example(tmp_path, monkeypatch):
    page = (HERE / "results" / "gallery.md").read_text(encoding="utf-8")
    for path in EXAMPLES:
        assert f"(../gallery/{path.name})" in page
        assert (HERE / "results" / f"gallery_{path.stem}.png").stat().st_size < 150_000
    quickest = [path for path in EXAMPLES if path.stem in ("editing", "geodesics", "smoothing")]
    monkeypatch.setattr("benchmarks.gallery.EXAMPLES", quickest)
    run(True, tmp_path)
    assert len(list(tmp_path.iterdir())) == 3
