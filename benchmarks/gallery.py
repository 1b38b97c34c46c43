"""The gallery: twenty short scripts in benchmarks/gallery, each with its picture and what it prints."""

from __future__ import annotations

__all__ = ["EXAMPLES", "run", "run_example"]

import ast
import contextlib
import io
import os
import runpy
import tempfile
from collections.abc import Iterator
from pathlib import Path

from benchmarks.harness import save_markdown

HERE = Path(__file__).parent
MESHES = HERE.parent / "meshes"
EXAMPLES = sorted((HERE / "gallery").glob("*.py"))
WIDTH, N_COLORS = 900, 128  # of the pictures that are kept, which are to be small
MAX_LINES = 12  # of what an example prints that are kept


def run_example(path: Path, folder: Path) -> tuple[bytes, str]:
    """Run a script in a folder that has the meshes; its picture, made small, and what it prints.

    A script writes a picture of its own name, and fails where what it claims does not hold.
    """
    from PIL import Image

    (folder / "meshes").symlink_to(MESHES, target_is_directory=True)
    printed = io.StringIO()
    with _inside(folder), contextlib.redirect_stdout(printed):
        runpy.run_path(str(path), run_name="__main__")
    content = io.BytesIO()
    with Image.open(folder / f"{path.stem}.png") as picture:
        small = picture.convert("RGB")
        small.thumbnail((WIDTH, WIDTH))
        small.quantize(N_COLORS).save(content, "png", optimize=True)
    return content.getvalue(), printed.getvalue()


@contextlib.contextmanager
def _inside(folder: Path) -> Iterator[None]:
    """Work in a folder."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def run(quick: bool, results: Path) -> None:
    """Write gallery.md and a picture for each script."""
    sections = {}
    for path in EXAMPLES[:2] if quick else EXAMPLES:
        with tempfile.TemporaryDirectory() as folder:
            picture, printed = run_example(path, Path(folder))
        (results / f"gallery_{path.stem}.png").write_bytes(picture)
        text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        lines = printed.splitlines()
        shown = "\n".join([*lines[:MAX_LINES], *(["..."] if len(lines) > MAX_LINES else [])])
        output = f"\n\n```text\n{shown}\n```" if shown else ""
        links = f"[{path.name}](../gallery/{path.name})\n\n![{path.stem}](gallery_{path.stem}.png)"
        sections[path.stem.replace("_", " ").capitalize()] = f"{text}\n\n{links}{output}"
    beside = "[Twelve meshes from two sides, beside CGAL and PyGEL3D](gallery_meshes.md)"
    save_markdown(results / "gallery.md", "Gallery", {**sections, "Real meshes": beside})
