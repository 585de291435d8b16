"""Trees over row elements: they tile their parents, and pulling is the transpose of pushing."""

import numpy as np
import pytest
from rooms import SceneBuilder

from hradiosity.space.hierarchy import build_elements
from hradiosity.space.nodes import ROOT, build_nodes


def nodes_of(size, *, back=False, triangle=False, edges=((1.0, 0.0, 0.0), (0.2, 0.7, 0.0))):
    builder = SceneBuilder()
    paint = builder.material(0.5)
    builder.patch((0, 0, 0), *edges, paint, triangle=triangle)
    builder.patch((0, 0, 2), (0.03, 0, 0), (0, 0.03, 0), paint)
    builder.patch((0.04, 0, 2), (0.03, 0, 0), (0, 0.03, 0.001), paint)
    patches = builder.scene().patches
    space = np.array([[-1, 0] if back else [0, -1], [0, -1], [0, -1]], np.int32)
    elements = build_elements(patches, space, np.array([True]), size)
    return patches, elements, build_nodes(patches, elements)


@pytest.mark.parametrize("triangle", [False, True])
@pytest.mark.parametrize("back", [False, True])
@pytest.mark.parametrize("size", [0.5, 0.21, 0.1, 0.07])
def test_children_tile_their_parents(size, back, triangle):
    _, elements, nodes = nodes_of(size, back=back, triangle=triangle)
    area, centre = nodes.areas(), nodes.facets.corners.mean(axis=1)
    np.testing.assert_allclose(area[: len(elements)], elements.area, rtol=1e-12)
    gathered = nodes.gathering() @ elements.area
    np.testing.assert_allclose(gathered, area, rtol=1e-12)
    assert nodes.n_levels > 1 + (size < 0.2) or size == 0.5
    for node in np.flatnonzero(~nodes.is_leaf):
        children = nodes.child[nodes.child_start[node] : nodes.child_start[node + 1]]
        assert len(children) >= 1 and (nodes.parent[children] == node).all()
        corners = nodes.facets.corners[nodes.facet_start[node]]
        normal = nodes.facets.normal[nodes.facet_start[node]]
        edge = np.roll(corners, -1, axis=0) - corners
        inward = np.cross(normal, edge)
        facet = nodes.facet_start[children]
        for corner in (*centre[facet], *nodes.facets.corners[facet].reshape(-1, 3)):
            assert (np.einsum("ed,ed->e", inward, corner - corners) > -1e-12).all()


@pytest.mark.parametrize("back", [False, True])
def test_corners_run_counter_clockwise_about_the_normal(back):
    _, _, nodes = nodes_of(0.1, back=back, triangle=True)
    corners = nodes.facets.corners
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("nd,nd->n", across, nodes.facets.normal) > 0.0).all()


def test_groups_stay_leaves_and_keep_their_facets():
    _, elements, nodes = nodes_of(0.3)
    group = elements.cell_row[elements.first_cell[1, 0]]
    assert group == elements.cell_row[elements.first_cell[2, 0]]
    assert nodes.parent[group] == ROOT
    assert nodes.facet_start[group + 1] - nodes.facet_start[group] == 2
    assert set(nodes.facets.patch[nodes.facet_start[group] : nodes.facet_start[group + 1]]) == {1, 2}


def test_each_side_has_one_root():
    _, _, nodes = nodes_of(0.07)
    assert len(nodes.roots) == 2
    assert (nodes.parent[: nodes.level_start[1]] >= nodes.level_start[1]).sum() == nodes.n_rows - 1


def test_merging_by_fours_keeps_the_shape():
    _, _, nodes = nodes_of(0.06, edges=((0.96, 0, 0), (0, 0.96, 0)))
    edges = np.linalg.norm(np.diff(nodes.facets.corners, axis=1), axis=2)
    squares = nodes.facets.patch == 0
    np.testing.assert_allclose(edges[squares].max(axis=1), edges[squares].min(axis=1))
    np.testing.assert_array_equal(np.diff(nodes.level_start), [257, 64, 16, 4, 1])
