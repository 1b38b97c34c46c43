"""The memory that a run takes, estimated from the number of faces before anything large is allocated."""

from __future__ import annotations

__all__ = ["free_megabytes", "megabytes_needed", "require_memory_options", "simplify_within"]

from pathlib import Path

from lbskel.errors import MemoryLimitError, UnknownChoice, choose, counted
from lbskel.geometry.mesh import Mesh

# Megabytes for each million faces, with a proxy and without, beside those of Python and its libraries. In
# benchmarks/results/proxies.md a thin shape of 489,000 faces takes 604 and 737 MB, of 1,957,000 faces 2,120 and 2,660.
# Thick ones take less, of 5,000,000 faces 3,750 and 5,720 with the libraries, in benchmarks/results/speed.md.
PER_MILLION_FACES = {"auto": 1240.0, "none": 1510.0}
LIBRARIES = 110.0  # megabytes of the process of a small mesh, in speed.md
MEMORY_INFO = Path("/proc/meminfo")  # Linux's account of the memory


def megabytes_needed(n_faces: int, simplify: str) -> float:
    """Estimate the peak memory of a run, in megabytes.

    Parameters
    ----------
    n_faces : int
    simplify : str
        As for :func:`lbskel.skeletonize`.

    Raises
    ------
    UnknownChoice
        If ``simplify`` is neither ``auto`` nor ``none``.
    """
    return LIBRARIES + choose(PER_MILLION_FACES, simplify, "way to simplify") * n_faces / 1e6


def free_megabytes() -> float:
    """Return the megabytes of memory that the machine has free; infinite where the system does not report them."""
    try:
        lines = MEMORY_INFO.read_text(encoding="ascii").splitlines()
    except OSError:
        return float("inf")
    kibibytes = [float(line.split()[1]) for line in lines if line.startswith("MemAvailable:")]
    return kibibytes[0] * 1024 / 1e6 if kibibytes else float("inf")


def require_memory_options(simplify: str, memory_limit: float | None) -> None:
    """Raise UnknownChoice for options without meaning, as :func:`simplify_within` has them, before any work is done."""
    choose(PER_MILLION_FACES, simplify, "way to simplify")
    if memory_limit is not None and not memory_limit > 0:
        raise UnknownChoice(f"memory_limit must be a positive number of megabytes, not {memory_limit}")


def simplify_within(mesh: Mesh, simplify: str, memory_limit: float | None) -> tuple[str, list[str]]:
    """Return how to simplify a mesh within a limit on the memory, and a note where that is not what was asked for.

    Parameters
    ----------
    mesh : Mesh
    simplify : str
        What was asked for; a mesh that cannot be contracted in full is contracted by a proxy.
    memory_limit : float, optional
        In megabytes; what the machine has free by default.

    Raises
    ------
    MemoryLimitError
        If the mesh cannot be contracted by a proxy either.
    UnknownChoice
        If ``simplify`` is neither ``auto`` nor ``none``.
    """
    limit = free_megabytes() if memory_limit is None else memory_limit
    needed = megabytes_needed(len(mesh.faces), simplify)
    if needed <= limit:
        return simplify, []
    least = megabytes_needed(len(mesh.faces), "auto")
    if least <= limit:
        return "auto", [
            f"contracted by a proxy, since in full it would take {needed:,.0f} MB of memory of {limit:,.0f}"
        ]
    raise MemoryLimitError(
        f"a mesh of {counted(len(mesh.faces), 'face')} takes about {least:,.0f} MB of memory, and the limit is "
        f"{limit:,.0f}: simplify it first, with lbskel preprocess or another tool, or raise memory_limit"
    )
