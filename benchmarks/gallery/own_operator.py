"""A Laplacian of one's own drives the contraction: any function from a mesh to a Laplacian."""

import numpy as np
from scipy.sparse import coo_array, diags_array

import lbskel
from lbskel.visualization import Panel, render


def gaussian_weights(mesh):
    """Weights that fall with the squared length of an edge, and areas as masses."""
    i, j = mesh.edges.T
    squared = ((mesh.vertices[i] - mesh.vertices[j]) ** 2).sum(axis=1)
    weights = np.exp(-squared / (2 * squared.mean()))
    n = len(mesh.vertices)
    W = coo_array((weights, (i, j)), shape=(n, n))
    W = (W + W.T).tocsc()
    areas = np.bincount(mesh.faces.ravel(), np.repeat(mesh.face_areas / 3, 3), n)
    return lbskel.Laplacian((diags_array(W.sum(axis=1)) - W).tocsc(), diags_array(areas).tocsc())


mesh = lbskel.read_mesh("meshes/hand.ply")
own = lbskel.skeletonize(mesh, operator=gaussian_weights)
default = lbskel.skeletonize(mesh)
render([Panel(mesh, default, "default"), Panel(mesh, own, "Gaussian weights")], "own_operator.png")

assert len(own.tips) == len(default.tips)
distance = lbskel.ground_truth_distances(own, default).accuracy
print(f"{distance:.3f} local radii from the default")
assert distance < 0.2
