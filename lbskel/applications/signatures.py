"""Heat kernel and wave kernel signatures: a vector of numbers for each vertex that isometries do not change.

With eigenpairs (lambda_i, x_i): HKS(v, t) = sum_i exp(-lambda_i t) x_i(v)^2, the heat that stays at v after the time t.
Sun, Ovsjanikov, Guibas 2009, https://doi.org/10.1111/j.1467-8659.2009.01515.x, section 4. WKS(v, e) = C_e^-1
sum_i x_i(v)^2 exp(-(e - log lambda_i)^2 / 2 sigma^2), the probability to find a particle of energy e at v. Aubry,
Schlickewei, Cremers 2011, https://doi.org/10.1109/ICCVW.2011.6130444, section 4.
"""

from __future__ import annotations

__all__ = ["heat_kernel_signature", "wave_kernel_signature"]


import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lbskel.applications.basis import SpectralBasis
from lbskel.errors import MeshError, is_number

N_SCALES = 100  # times or energies by default, as in both papers
LATEST_EXPONENT = 4 * np.log(10)  # lambda t of the first and last time: exp(-lambda t) is 1e-4. Sun et al. 2009
WIDTH = 7  # standard deviation of the energies, in steps between them. Aubry et al. 2011


def heat_kernel_signature(basis: SpectralBasis, times: ArrayLike | None = None) -> NDArray[np.float64]:
    """Compute the heat kernel signature of each vertex.

    Parameters
    ----------
    basis : SpectralBasis
    times : (t,) array_like of float, optional
        In length^2, but without a unit where masses are degrees; not negative. By default 100, in equal ratios, from
        4 log 10 over the largest eigenvalue to 4 log 10 over the smallest positive one.

    Returns
    -------
    (n, t) array of float
        In 1 / length^2 where masses are areas: under a scaling by s, the signature at the time s^2 t is divided by s^2.
        Where they are lengths, in 1 / length, and where they are degrees, without a unit, as is the time.

    Raises
    ------
    MeshError
        If a time is negative or not finite, or there are none and the basis has no positive eigenvalue.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import sphere
    >>> signature = lbskel.heat_kernel_signature(lbskel.spectral_basis(sphere(3), 30), [100.0])
    >>> float((signature[0, 0] * 4 * 3.14159).round(2))
    1.0
    """
    if times is None:
        positive = _positive_values(basis)
        t = np.geomspace(LATEST_EXPONENT / positive[-1], LATEST_EXPONENT / positive[0], N_SCALES)
    else:
        t = _scales(times, "times")
        if (t < 0).any():
            raise MeshError("the times of a heat kernel signature must not be negative")
    with np.errstate(under="ignore"):
        signature: NDArray[np.float64] = basis.functions**2 @ np.exp(-np.maximum(basis.values, 0.0)[:, None] * t)
    return signature


def wave_kernel_signature(
    basis: SpectralBasis, energies: ArrayLike | None = None, *, width: float | None = None
) -> NDArray[np.float64]:
    """Compute the wave kernel signature of each vertex.

    Parameters
    ----------
    basis : SpectralBasis
        Eigenvalues of zero are left out.
    energies : (e,) array_like of float, optional
        Logarithms of eigenvalues. By default 100, in equal steps over those of the basis.
    width : float, optional
        Standard deviation of the energies, in the same unit; by default seven of their steps.

    Returns
    -------
    (n, e) array of float
        In 1 / length^2 where masses are areas, else as for :func:`heat_kernel_signature`.

    Raises
    ------
    MeshError
        If the basis has no positive eigenvalue, an energy is not finite, or the width is not positive, as it is by
        default with a single energy or eigenvalue.

    Examples
    --------
    >>> import lbskel
    >>> from lbskel.shapes import torus
    >>> lbskel.wave_kernel_signature(lbskel.spectral_basis(torus(1.0, 0.3), 30)).shape[1]
    100
    """
    levels = np.log(_positive_values(basis))
    e = np.linspace(levels[0], levels[-1], N_SCALES) if energies is None else _scales(energies, "energies")
    if width is None:
        width = WIDTH * float(np.ptp(e)) / max(len(e) - 1, 1)
    if not (is_number(width) and math.isfinite(width) and width > 0):
        raise MeshError(
            "the width of an energy must be positive; give one where there is a single energy or eigenvalue"
        )
    exponents = -(((e - levels[:, None]) / width) ** 2) / 2
    with np.errstate(under="ignore"):
        weights = np.exp(exponents - exponents.max(axis=0))  # the factor cancels; far from all levels none underflows
        signature: NDArray[np.float64] = basis.functions[:, basis.positive] ** 2 @ (weights / weights.sum(axis=0))
    return signature


def _positive_values(basis: SpectralBasis) -> NDArray[np.float64]:
    """Return the eigenvalues that are not zero."""
    if not len(basis.positive):
        raise MeshError(
            f"none of the {len(basis.values)} eigenvalues is positive: ask for more than there are components"
        )
    values: NDArray[np.float64] = basis.values[basis.positive]
    return values


def _scales(given: ArrayLike, what: str) -> NDArray[np.float64]:
    """Return times or energies as a vector."""
    try:
        scales = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        scales = np.empty(0)
    if scales.ndim != 1 or not len(scales) or not np.isfinite(scales).all():
        raise MeshError(f"the {what} must be a list of finite numbers")
    return scales
