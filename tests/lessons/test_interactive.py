"""The interactive pages of the lessons: their formulas, run as the browser runs them, beside matrices of a bar and of a mesh; no page fetches anything."""

import re
import sys

import numpy as np
import pytest
import quickjs

from paths import ROOT

sys.path.insert(0, str(ROOT / "tools"))

from api_pages import fetches  # noqa: E402

FOLDER = ROOT / "docs/lessons/interactive"
PAGES = sorted(FOLDER.glob("*.html"))
CELLS = 24


@pytest.fixture(scope="module")
def theory():
    """The formulas; theory(text) is what an expression gives."""
    context = quickjs.Context()
    context.eval((FOLDER / "theory.js").read_text())
    return context.eval


def bar():
    """Mass, lumped mass and stiffness of a ring of cells of size 1 with points at the quarters, assembled point by point."""
    mass, stiffness = np.zeros((2, CELLS, CELLS))
    for cell in range(CELLS):
        nodes = [cell, (cell + 1) % CELLS]
        for place in (0.25, 0.75):
            shape, slope = np.array([1 - place, place]), np.array([-1.0, 1.0])
            mass[np.ix_(nodes, nodes)] += 0.5 * np.outer(shape, shape)
            stiffness[np.ix_(nodes, nodes)] += 0.5 * np.outer(slope, slope)
    return mass, np.diag(mass.sum(axis=1)), stiffness


@pytest.mark.parametrize("b", [0.0, 5 / 18, 1.0])
def test_frequencies_are_those_of_an_assembled_bar(theory, b):
    mass, lumped, stiffness = bar()
    inverse = np.linalg.inv((1 - b) * mass + b * lumped)
    phases = 2 * np.pi * np.arange(CELLS) / CELLS
    for elements, matrix in ((False, inverse @ mass @ inverse @ stiffness), (True, inverse @ stiffness)):
        measured = np.sort(np.sqrt(np.abs(np.linalg.eigvals(matrix))))
        found = np.sort([theory(f"frequency({q!r}, {b!r}, {str(elements).lower()})") for q in phases.tolist()])
        assert found[1:] == pytest.approx(measured[1:], rel=1e-10)


@pytest.mark.parametrize("scheme", ["musl", "usl"])
@pytest.mark.parametrize("b", [0.0, 5 / 18, 1.0])
def test_the_largest_factor_and_the_limit_are_those_of_the_matrix_of_a_step(theory, b, scheme):
    """A step changes the nodal momentum p and the displacement u that strains: usl strains by p before its change."""
    mass, lumped, stiffness = bar()
    inverse = np.linalg.inv((1 - b) * mass + b * lumped)
    one, zero = np.eye(CELLS), np.zeros((CELLS, CELLS))

    def largest(step):
        """With the nodal velocity that strains: A p - dt A K u of usl, A p after the change of p of the others."""
        kick = np.block([[one, -step * mass @ inverse @ stiffness], [zero, one]])
        if scheme == "usl":
            move = np.block([[one, -step * mass @ inverse @ stiffness], [step * inverse, one - step**2 * inverse @ stiffness]])
        else:
            move = np.block([[one, zero], [step * inverse, one]]) @ kick
        return np.abs(np.linalg.eigvals(move)).max()

    limit = theory(f"stableStep({b!r}, '{scheme}')")
    phases = (2 * np.pi * np.arange(1, CELLS) / CELLS).tolist()
    for step in (0.4, 1.02 * limit, 1.5 * limit):
        found = max(theory(f"amplification({q!r}, {b!r}, {step!r}, '{scheme}')") for q in phases)
        assert max(found, 1) == pytest.approx(largest(step), rel=1e-5)  # rigid motion, with 1 twice
    assert largest(0.98 * limit) < 1 + 1e-5 < largest(1.05 * limit)


def test_the_refinement_parameter_depends_on_the_distance_in_cells_alone(theory):
    """Far from the tip it is (c/2)^2 times the Laplacian of g(a)/r over g(a)/r, (c/2r)^2 (1 + g''/g) with g = (1 + cos a)(1.8 - cos a): 1.75 ahead."""
    for x, y in ((0.5, 0.5), (3, 1), (0, -2)):
        near, far = (theory(f"refinementParameter({s * x}, {s * y}, {s})") for s in (1, 0.125))
        assert near == pytest.approx(far, rel=1e-12)
    assert theory("refinementParameter(30, 0, 1)") == pytest.approx(1.75 * (1 / 60) ** 2, rel=0.01)


@pytest.mark.parametrize("limit, level", [(0.3, 3), (0.03, 4), (0.002, 3), (0.05, 0)])
def test_the_mesh_is_whole_and_its_neighbours_differ_by_one_level(theory, limit, level):
    leaves = [tuple(map(int, leaf.split(","))) for leaf in theory(f"refinedMesh(8, {limit}, {level}).join(';')").split(";")]
    cover = np.full((16 << level, 16 << level), -1)
    for depth, i, j in leaves:
        size = 1 << (level - depth)
        row, column = (j + (8 << depth)) * size, (i + (8 << depth)) * size
        assert (cover[row:row + size, column:column + size] == -1).all()
        cover[row:row + size, column:column + size] = depth
    assert (cover >= 0).all() and cover.max() <= level
    assert max(np.abs(np.diff(cover, axis=axis)).max() for axis in (0, 1)) <= 1
    assert (cover == cover[::-1]).all()  # the mode is symmetric


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_works_from_its_file_without_a_network(page):
    text = page.read_text()
    assert fetches(text) == [] and "//" not in re.sub(r"<!doctype.*?>|xmlns=\S+", "", text)
    for name in re.findall(r'(?:src|href)="([^"#]+)"', text):
        assert (FOLDER / name).exists(), name
    named = set(re.findall(r'id="(\w+)"', text))
    asked = set(re.findall(r'(?:value|say|getElementById)\("(\w+)"', text))
    assert asked <= named and set(re.findall(r'for="(\w+)"', text)) <= named
    assert all(re.search(r'aria-label="[^"]+"', svg) for svg in re.findall(r"<svg[^>]*>", text))
