"""The branches of a skeleton as a table: ends, order, lengths, radii, cross-sections, volume, surface and angles.

Lengths and radii are those of the polyline. With the mesh, cross-sections, area and volume are those of the surface:
:mod:`lbskel.applications.branch_measures`. Order and angles: :mod:`lbskel.applications.branch_tree`.
"""

from __future__ import annotations

__all__ = ["BranchTable", "branch_table"]

import csv
import io
import json
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lbskel.applications.branch_measures import N_PROFILE, Polyline, section_areas, shared_among_branches
from lbskel.applications.branch_tree import branch_order
from lbskel.errors import MeshError, MissingDependency, UnknownChoice
from lbskel.geometry.arrays import read_only, to_builtin
from lbskel.geometry.mesh import Mesh, as_mesh
from lbskel.geometry.scaling import require_scale
from lbskel.preprocess import oriented_surface
from lbskel.preprocess.subdivision import refine
from lbskel.skeleton.skeleton import Skeleton
from lbskel.skeleton.source import require_map

# Columns with a unit, and the power of the factor between two units with which each grows
_LENGTHS = ("start_point", "end_point", "length", "chord", "mean_radius", "min_radius", "max_radius", "radius_profile")
_POWERS = dict.fromkeys(_LENGTHS, 1) | {"section_area": 2, "area": 2, "section_area_profile": 2, "volume": 3}


@dataclass(frozen=True, eq=False)
class BranchTable:
    """One row for each branch of a skeleton, in its units or those asked for.

    Parameters
    ----------
    start, end : (b,) array of int
        Nodes at the ends; the start is nearer to the root.
    parent : (b,) array of int
        Row of the branch's parent; -1 where the branch begins at the root or has the root inside.
    centrifugal : (b,) array of int
        Centrifugal order: number of ancestors, 0 where the parent is -1.
    strahler : (b,) array of int
        Strahler order.
    start_point, end_point : (b, 3) array of float
        Positions of the ends.
    length, chord : (b,) array of float
        Length of the polyline, and of the line between its ends.
    tortuosity : (b,) array of float
        Length over chord; NaN for loops.
    mean_radius, min_radius, max_radius : (b,) array of float
        Mean along the length, smallest and largest of the radii of the nodes.
    section_area : (b,) array of float
        Mean area of the cross-sections more than two junction radii from junctions; NaN without a mesh or sections, as
        on a branch that is not longer.
    area, volume : (b,) array of float
        Of the part of the mesh that belongs to the branch; the volumes of all sum to that of the mesh but for a few
        percent. Without a mesh, side area and volume of truncated cones.
    area_share, volume_share : (b,) array of float
        Fractions of the sums over the branches.
    local_angle, remote_angle : (b,) array of float
        Degrees between the two children at the end: between their first edges, and between the lines to their ends;
        NaN for a branch that does not have two children there.
    radius_profile, section_area_profile : (b, 11) array of float
        Radius and area of the cross-section at 0, 10, ... 100 % of the length.
    units : str, optional
        Name of the units of lengths.

    Examples
    --------
    >>> import lbskel
    >>> stick = lbskel.Skeleton([[0, 0, 0], [3, 0, 0], [3, 4, 0]], [[0, 1], [1, 2]], [1, 1, 1])
    >>> table = lbskel.branch_table(stick)
    >>> float(table.length[0]), float(table.chord[0]), float(table.tortuosity[0])
    (7.0, 5.0, 1.4)
    """

    start: NDArray[np.int64]
    end: NDArray[np.int64]
    parent: NDArray[np.int64]
    centrifugal: NDArray[np.int64]
    strahler: NDArray[np.int64]
    start_point: NDArray[np.float64]
    end_point: NDArray[np.float64]
    length: NDArray[np.float64]
    chord: NDArray[np.float64]
    tortuosity: NDArray[np.float64]
    mean_radius: NDArray[np.float64]
    min_radius: NDArray[np.float64]
    max_radius: NDArray[np.float64]
    section_area: NDArray[np.float64]
    area: NDArray[np.float64]
    volume: NDArray[np.float64]
    area_share: NDArray[np.float64]
    volume_share: NDArray[np.float64]
    local_angle: NDArray[np.float64]
    remote_angle: NDArray[np.float64]
    radius_profile: NDArray[np.float64]
    section_area_profile: NDArray[np.float64]
    units: str | None = None

    def __len__(self) -> int:
        return len(self.length)

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return the columns by name.

        A point has three, such as ``start_x``, and a profile one for each place, such as ``radius_at_50`` percent; the
        last one is ``units``, if they are named.
        """
        places = np.linspace(0, 100, N_PROFILE).round().astype(int).tolist()
        columns: dict[str, NDArray[Any]] = {"branch": np.arange(len(self))}
        for name, values in self._arrays().items():
            if values.ndim == 1:
                columns[name] = values
            elif name.endswith("_point"):
                columns |= {name.replace("point", axis): values[:, k] for k, axis in enumerate("xyz")}
            else:
                of = name.removesuffix("_profile")
                columns |= {f"{of}_at_{place}": values[:, k] for k, place in enumerate(places)}
        return columns if self.units is None else columns | {"units": np.full(len(self), self.units)}

    def _arrays(self) -> dict[str, NDArray[Any]]:
        """Return the fields with a row for each branch, by name."""
        return {each.name: getattr(self, each.name) for each in fields(self) if each.name != "units"}

    def to_csv(self) -> str:
        """Return the table as CSV, one line for each branch; NaN is an empty field."""
        columns, text = self.columns(), io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        rows = zip(*(column.tolist() for column in columns.values()), strict=True)
        writer.writerows(["" if value != value else value for value in row] for row in rows)
        return text.getvalue()

    def to_json(self) -> str:
        """Return the table as JSON: units, and an object for each branch.

        What is not finite or not known is null, a point or a profile a list.
        """
        columns = to_builtin(self._arrays())
        rows = [{"branch": row, **{name: values[row] for name, values in columns.items()}} for row in range(len(self))]
        return json.dumps({"units": self.units, "branches": rows}, indent=1) + "\n"

    def to_pandas(self) -> Any:
        """Return the table as a ``pandas.DataFrame`` with the columns of :meth:`columns`.

        Raises
        ------
        MissingDependency
            If pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise MissingDependency("pandas", "tables", "to_pandas()") from None
        return pandas.DataFrame(self.columns()).set_index("branch")


def branch_table(skeleton: Skeleton, mesh: Any = None, *, scale: float = 1.0, units: str | None = None) -> BranchTable:
    """Measure every branch of a skeleton.

    Parameters
    ----------
    skeleton : Skeleton
        With ``node_of_vertex``, if the mesh is given. Its first node is the root.
    mesh : Mesh or anything that :func:`lbskel.as_mesh` takes, optional
        The mesh that the skeleton was made from; it may be inside out or of mixed orientation.
    scale : float
        Factor of the lengths and positions in the table, such as 0.001 from nanometers to micrometers; areas and
        volumes have its square and its cube.
    units : str, optional
        Name of the units of lengths in the table, such as ``um``.

    Returns
    -------
    BranchTable
        In the order of ``skeleton.branches``.

    Raises
    ------
    MeshError
        If the first argument is no skeleton, or one that maps another number of vertices than the mesh has or lies
        elsewhere, as in other units.
    UnknownChoice
        If the scale is not a positive number, or its cube is none.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import capsule
    >>> rod = capsule(4.0, 0.5)
    >>> table = lbskel.branch_table(lbskel.skeletonize(rod), rod)
    >>> len(table), float(table.mean_radius[0].round(2)), float(table.section_area[0].round(2))
    (1, 0.5, 0.78)
    """
    if not isinstance(skeleton, Skeleton):
        raise MeshError(
            f"a table of branches needs a Skeleton and its mesh, in this order, not {type(skeleton).__name__} first"
        )
    require_scale(scale)
    order = branch_order(skeleton)
    lines = [Polyline.of(skeleton, path) for path in order.paths]
    length = np.array([line.length for line in lines])
    chord = np.array([float(np.linalg.norm(line.points[-1] - line.points[0])) for line in lines])
    places = np.linspace(0, 1, N_PROFILE)
    profile = np.array([line.radii_at(places * line.length) for line in lines]).reshape(-1, N_PROFILE)
    if mesh is None:
        cones = np.array([line.cones() for line in lines]).reshape(-1, 2)
        area, volume = cones.T.copy()
        section, section_profile = np.full(len(lines), np.nan), np.full((len(lines), N_PROFILE), np.nan)
    else:
        surface = oriented_surface(as_mesh(mesh))[0]
        area, volume = shared_among_branches(*_refined(skeleton, surface), order.paths)
        section, section_profile = section_areas(skeleton, order.paths, lines, surface)
    ends = np.array([(path[0], path[-1]) for path in order.paths], dtype=np.int64).reshape(-1, 2)
    values = {
        "start": ends[:, 0].copy(),
        "end": ends[:, 1].copy(),
        "parent": order.parents,
        "centrifugal": order.centrifugal,
        "strahler": order.strahler,
        "start_point": skeleton.nodes[ends[:, 0]],
        "end_point": skeleton.nodes[ends[:, 1]],
        "length": length,
        "chord": chord,
        "tortuosity": np.divide(length, chord, out=np.full(len(lines), np.nan), where=chord > 0),
        "mean_radius": np.array([line.mean_radius for line in lines]),
        "min_radius": np.array([line.radii.min() for line in lines]),
        "max_radius": np.array([line.radii.max() for line in lines]),
        "section_area": section,
        "area": area,
        "volume": volume,
        "area_share": _share(area),
        "volume_share": _share(volume),
        "local_angle": order.local_angles,
        "remote_angle": order.remote_angles,
        "radius_profile": profile,
        "section_area_profile": section_profile,
    }
    with np.errstate(over="ignore", under="ignore"):
        factors = {name: np.float64(scale) ** power for name, power in _POWERS.items()}
    if not (np.isfinite(list(factors.values())).all() and min(factors.values()) > 0):
        raise UnknownChoice(f"a scale of {scale:g} is too large or too small for areas and volumes")
    scaled = {name: column * factors[name] if name in factors else column for name, column in values.items()}
    return BranchTable(**{name: read_only(column) for name, column in scaled.items()}, units=units)


def _refined(skeleton: Skeleton, surface: Mesh) -> tuple[Skeleton, Mesh]:
    """Split long faces, which may belong to one branch by two corners and to another by the third.

    The vertices between go to the nearest nodes.
    """
    require_map(skeleton, surface.vertices)
    fine = refine(surface).mesh
    added = fine.vertices[len(surface.vertices) :]
    if not len(added):
        return skeleton, surface
    nodes = cKDTree(skeleton.nodes).query(added)[1]
    return replace(skeleton, node_of_vertex=np.append(skeleton.node_of_vertex, nodes)), fine


def _share(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """(b,) shares of the sum; NaN if that is not positive and finite."""
    total = values.sum()
    return values / total if 0 < total < np.inf else np.full(len(values), np.nan)
