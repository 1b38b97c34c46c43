"""Skeletons as objects of other packages: networkx, pyvista, trimesh, pandas; and their interactive view."""

from __future__ import annotations

__all__ = ["SkeletonExchange"]

from typing import TYPE_CHECKING, Any, cast

import numpy as np

from lbskel.display import Displayed
from lbskel.errors import MissingDependency
from lbskel.geometry.exchange import CopiedByFields
from lbskel.geometry.mesh import PointCloud, as_mesh

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lbskel.skeleton.skeleton import Skeleton


class SkeletonExchange(CopiedByFields, Displayed):
    """Conversion of a skeleton to objects of other packages, and its interactive view."""

    def plot(self, mesh: Any = None) -> Any:
        """Make an interactive view, which a notebook shows; ``plot(mesh).save("skeleton.html")`` writes it.

        Parameters
        ----------
        mesh : PointCloud, Mesh, or what :func:`lbskel.as_mesh` takes, optional
            What the skeleton was made from. :func:`lbskel.view` shows the contraction and the score too.

        Raises
        ------
        MeshError
            If the mesh is not one.
        MissingDependency
            If plotly is not installed.
        """
        shape = mesh if mesh is None or isinstance(mesh, PointCloud) else as_mesh(mesh)
        return self._plot(mesh=shape, skeleton=self, title=repr(self))

    def branch_of_edge(self) -> NDArray[np.int64]:
        """Return the (e,) branch of each edge, as numbered in ``branches``."""
        skeleton = cast("Skeleton", self)
        nodes, begins = skeleton.flat_branches
        numbers = np.repeat(np.arange(len(begins) - 1), np.diff(begins) - 1)
        start = np.delete(np.arange(len(nodes)), begins[1:] - 1)
        pairs = np.sort(np.stack([nodes[start], nodes[start + 1]], axis=1), axis=1)
        branch: NDArray[np.int64] = numbers[np.lexsort(pairs.T[::-1])]  # the order of the edges, each of one branch
        return branch

    def to_networkx(self) -> Any:
        """Convert to an undirected ``networkx.Graph``.

        Nodes have ``pos`` and ``radius``; edges ``length``, ``radius``, the mean of that of their ends, and ``branch``.

        Raises
        ------
        MissingDependency
            If networkx is not installed.

        Examples
        --------
        >>> import lbskel
        >>> stick = lbskel.Skeleton([[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1], [1, 2]], [0.1, 0.2, 0.1])
        >>> stick.to_networkx().edges[0, 1]["branch"]
        0
        """
        skeleton = cast("Skeleton", self)
        try:
            import networkx
        except ImportError:
            raise MissingDependency("networkx", "graph", "to_networkx()") from None
        graph = networkx.Graph()
        for index, (position, radius) in enumerate(zip(skeleton.nodes, skeleton.radii, strict=True)):
            graph.add_node(index, pos=tuple(position.tolist()), radius=float(radius))
        branches = skeleton.branch_of_edge().tolist()
        radii = (skeleton.radii[skeleton.edges] / 2).sum(axis=1).tolist()  # their sum may overflow
        lengths = skeleton.edge_lengths.tolist()
        for (start, end), length, radius, branch in zip(skeleton.edges.tolist(), lengths, radii, branches, strict=True):
            graph.add_edge(start, end, length=length, radius=radius, branch=branch)
        return graph

    def to_pyvista(self) -> Any:
        """Convert to a ``pyvista.PolyData`` of one polyline for each branch.

        Points have ``radius``, lines the number of their ``branch``.
        ``skeleton.to_pyvista().tube(scalars="radius", absolute=True)`` makes tubes.

        Raises
        ------
        MissingDependency
            If pyvista is not installed.
        """
        skeleton = cast("Skeleton", self)
        try:
            import pyvista
        except ImportError:
            raise MissingDependency("pyvista", "pyvista", "to_pyvista()") from None
        lines = np.concatenate(
            [np.empty(0, dtype=np.int64), *(np.append(len(path), path) for path in skeleton.branches)]
        )
        data = pyvista.PolyData(skeleton.nodes.copy(), lines=lines)
        data.point_data["radius"] = skeleton.radii
        data.cell_data["branch"] = np.arange(len(skeleton.branches))
        return data

    def to_trimesh(self) -> Any:
        """Convert to a ``trimesh.path.Path3D`` of one polyline for each branch."""
        skeleton = cast("Skeleton", self)
        from trimesh.path import Path3D
        from trimesh.path.entities import Line

        line: Any = Line  # without types
        return Path3D([line(path) for path in skeleton.branches], skeleton.nodes.copy(), process=False)

    def to_pandas(self) -> Any:
        """Return the nodes as a ``pandas.DataFrame``; :func:`lbskel.branch_table` has the branches.

        Columns: x, y, z, radius, degree, component, and the branch of nodes that are no junctions, else -1.

        Raises
        ------
        MissingDependency
            If pandas is not installed.
        """
        skeleton = cast("Skeleton", self)
        try:
            import pandas
        except ImportError:
            raise MissingDependency("pandas", "tables", "to_pandas()") from None
        columns = dict(zip("xyz", skeleton.nodes.T, strict=True))
        columns |= {"radius": skeleton.radii, "degree": skeleton.degrees}
        columns |= {"component": skeleton.component_of_node, "branch": skeleton.branch_of_node}
        return pandas.DataFrame(columns).rename_axis("node")
