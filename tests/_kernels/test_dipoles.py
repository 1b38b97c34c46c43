"""The field of dipoles, against its sum over all points."""

import numpy as np
import pytest

from lbskel.preprocess.dipole_tree import LEAF, DipoleTree, leaf_order

rng = np.random.default_rng(4)
POINTS, MOMENTS, WIDTHS = rng.normal(size=(50, 3)), rng.normal(size=(50, 3)), rng.uniform(0.1, 0.3, 50)
QUERIES = rng.normal(size=(9, 3)) * 2


def summed(queries):
    D = POINTS - queries[:, None]
    s = np.sqrt((D**2).sum(axis=2) + WIDTHS**2)
    product = (D * MOMENTS).sum(axis=2)
    value = (product / s**3).sum(axis=1)
    gradient = (3 * (product / s**5)[..., None] * D - MOMENTS / s[..., None] ** 3).sum(axis=1)
    return np.column_stack([value, gradient]) / (4 * np.pi)


def test_all_nodes_opened_give_the_sum(kernel):
    tree = DipoleTree.of(POINTS, MOMENTS, WIDTHS, leaf_order(POINTS))
    field = kernel.dipole_field(tree.nodes, tree.leaves, QUERIES, LEAF, 1e9, True)
    assert field == pytest.approx(summed(QUERIES), rel=1e-12, abs=1e-12)  # rounding


def test_far_nodes_count_as_one_dipole(kernel):
    far = QUERIES + [30.0, 0, 0]
    tree = DipoleTree.of(POINTS, MOMENTS, WIDTHS, leaf_order(POINTS))
    field = kernel.dipole_field(tree.nodes, tree.leaves, far, LEAF, 2.0, True)
    # the quadrupole that is left out is smaller by radius over distance
    assert field == pytest.approx(summed(far), abs=0.2 * np.abs(summed(far)).max())


def test_the_field_alone_is_the_same(kernel):
    tree = DipoleTree.of(POINTS, MOMENTS, WIDTHS, leaf_order(POINTS))
    both = kernel.dipole_field(tree.nodes, tree.leaves, QUERIES, LEAF, 2.0, True)
    alone = kernel.dipole_field(tree.nodes, tree.leaves, QUERIES, LEAF, 2.0, False)
    np.testing.assert_array_equal(alone, both[:, :1])


def test_compiled_or_not_is_the_same(assert_same):
    tree = DipoleTree.of(POINTS, MOMENTS, WIDTHS, leaf_order(POINTS))
    assert_same(lambda kernel: [kernel.dipole_field(tree.nodes, tree.leaves, QUERIES, LEAF, 2.0, True)])
