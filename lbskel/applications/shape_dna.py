"""Shape-DNA: the spectrum as the fingerprint of a shape, which needs no correspondence.

The eigenvalues times the area do not change with size. By Weyl's law the i-th is about 4 pi i, so that all count alike
once each is divided by its number i. Reuter, Wolter, Peinecke 2006, "Laplace-Beltrami spectra as 'Shape-DNA' of
surfaces and solids", https://doi.org/10.1016/j.cad.2005.10.011; the weights: Konukoglu et al. 2013,
https://doi.org/10.1109/TMI.2013.2262236. lapy.shapedna has the same normalization and weights.
"""

from __future__ import annotations

__all__ = ["shape_dna_distance"]

import numpy as np

from lbskel.applications.basis import SpectralBasis
from lbskel.errors import MeshError


def shape_dna_distance(first: SpectralBasis, second: SpectralBasis) -> float:
    """Compare two shapes by their spectra: the distance of their eigenvalues, times the area, divided by their numbers.

    Parameters
    ----------
    first, second : SpectralBasis
        By the same operator. The longer spectrum is cut to the length of the other.

    Returns
    -------
    float
        Euclidean, no unit. Zero for isometric shapes of any size.

    Raises
    ------
    MeshError
        If a basis has no positive eigenvalue.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import sphere, torus
    >>> a, b, c = (lbskel.spectral_basis(mesh, 20) for mesh in (sphere(3), sphere(4), torus(1.0, 0.3)))
    >>> lbskel.shape_dna_distance(a, b) < lbskel.shape_dna_distance(a, c)
    True
    """
    k = min(len(first.values), len(second.values))
    if not (len(first.positive) and len(second.positive)):
        raise MeshError("both spectra need positive eigenvalues: ask for more than there are components")
    difference = (first.values[:k] * first.area - second.values[:k] * second.area) / np.arange(1, k + 1)
    return float(np.linalg.norm(difference))
