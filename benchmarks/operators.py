"""Every operator: the properties that it keeps, how it converges, what it costs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from benchmarks import operators_convergence, operators_properties, operators_spectrum, operators_speed
from benchmarks.harness import save_json, save_markdown, save_picture


def run(quick: bool, results: Path, package: str | None = None) -> None:
    """Write operators_properties, _convergence, _spectrum and _speed, or one of them: JSON, Markdown, pictures."""
    for name in PARTS if package is None else [package]:
        PARTS[name](quick, results)


def properties(quick: bool, results: Path) -> None:
    """Measure which properties hold on which shape."""
    rows = operators_properties.measure(("good", "open") if quick else None)
    save_json(results / "operators_properties.json", {"quick": quick, "rows": rows})
    save_markdown(results / "operators_properties.md", "What each Laplacian keeps", operators_properties.tables(rows))


def convergence(quick: bool, results: Path) -> None:
    """Measure orders of convergence."""
    rows = operators_convergence.measure(range(3 if quick else 5))
    save_json(results / "operators_convergence.json", {"quick": quick, "rows": rows})
    tables = operators_convergence.tables(rows)
    save_markdown(results / "operators_convergence.md", "How each Laplacian converges", tables)
    save_picture(
        results / "operators_convergence.png", lambda figure: operators_convergence.picture(rows, figure), size=(13, 13)
    )


def spectrum(quick: bool, results: Path) -> None:
    """Compare spectra with LaPy's."""
    rows = operators_spectrum.measure((2_000,) if quick else (20_000, 80_000))
    save_json(results / "operators_spectrum.json", {"quick": quick, "rows": rows}, packages=["lapy"])
    save_markdown(results / "operators_spectrum.md", "Spectra compared with LaPy", operators_spectrum.tables(rows))


def speed(quick: bool, results: Path) -> None:
    """Measure time and memory."""
    sizes = (2_000, 10_000) if quick else (10_000, 100_000, 1_000_000)
    rows = operators_speed.measure(sizes, {n: 1 if quick else 3 if n > 500_000 else 9 for n in sizes})
    save_json(results / "operators_speed.json", {"quick": quick, "rows": rows}, packages=operators_speed.PACKAGES)
    save_markdown(results / "operators_speed.md", "What each Laplacian costs", operators_speed.tables(rows))
    save_picture(results / "operators_speed.png", lambda figure: operators_speed.picture(rows, figure), size=(11, 6))


PARTS: dict[str, Callable[[bool, Path], None]] = {
    "properties": properties,
    "convergence": convergence,
    "spectrum": spectrum,
    "speed": speed,
}
