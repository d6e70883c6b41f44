"""The hydraulic aperture against what is known exactly, and against bounds."""

import numpy as np
import pytest
import scipy

from benchmarks.published_gap import PUBLISHED_FLUXES, published_gap
from jointclosure.joint import flow as reynolds
from jointclosure.joint.flow import (
    AT_LEAST,
    BLOCKED,
    DIRECTIONS,
    FLOWS,
    NOT_SOLVED,
    flow_along,
    largest_hydraulic,
)


def random_field(seed: int, shape=(40, 60), contact=0.1) -> np.ndarray:
    """Apertures (y, x) [m], smooth over some cells, of which a share is in contact."""
    heights = np.random.default_rng(seed).normal(size=shape)
    for axis in (0, 1):
        for _ in range(4):
            heights = heights + np.roll(heights, 1, axis)
    return 1e-4 * np.maximum(heights - np.quantile(heights, contact), 0.0)


def along_first_axis(field: np.ndarray, direction: str) -> np.ndarray:
    return field.T if direction == "x" else field


CONTRASTS = pytest.mark.parametrize("contrast", [0.1, 0.5, 0.9])


def sinusoidal_gap(contrast):
    """h = h0 (1 + c sin) along x: <h^-3> and <h^3> over a period are known in closed form."""
    phase = 2.0 * np.pi * (np.arange(256) + 0.5) / 256
    return np.tile(2e-4 * (1.0 + contrast * np.sin(phase)), (8, 1))


@CONTRASTS
def test_flow_along_a_sinusoidal_gap_has_its_serial_average(contrast):
    gap = sinusoidal_gap(contrast)
    along = 2e-4 * ((1.0 - contrast**2) ** 2.5 / (1.0 + 0.5 * contrast**2)) ** (1.0 / 3.0)
    assert flow_along(gap, "x").hydraulic_aperture == pytest.approx(along, rel=1e-12)
    assert flow_along(gap.T, "y").hydraulic_aperture == pytest.approx(along, rel=1e-12)


@CONTRASTS
def test_flow_across_a_sinusoidal_gap_has_its_parallel_average(contrast):
    across = 2e-4 * (1.0 + 1.5 * contrast**2) ** (1.0 / 3.0)
    found = flow_along(sinusoidal_gap(contrast), "y").hydraulic_aperture
    assert found == pytest.approx(across, rel=1e-12)


def test_a_smooth_gap_converges_with_the_square_of_the_spacing():
    def found(cells: int) -> float:
        x, y = np.meshgrid(*2 * [(np.arange(cells) + 0.5) / cells])
        gap = 1.0 + 0.5 * np.sin(2.0 * np.pi * (x + 0.7 * y)) * np.cos(3.0 * y + x)
        return flow_along(gap, "x").hydraulic_aperture

    coarse, middle, fine = (found(cells) for cells in (40, 80, 160))
    order = np.log2((coarse - middle) / (middle - fine))
    assert order == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_a_blocked_field_has_an_upper_bound_unless_a_whole_line_is_shut(direction):
    field = np.kron(np.indices((6, 8)).sum(axis=0) % 2, np.ones((2, 2)))  # joined at corners only
    assert flow_along(field, direction).status == BLOCKED
    assert largest_hydraulic(field, direction) == pytest.approx(0.5 ** (1.0 / 3.0))
    along_first_axis(field, direction)[3] = 0.0
    assert largest_hydraulic(field, direction) == 0.0


@pytest.fixture
def field():
    """Apertures (y, x) [m] with a line of contacts across x."""
    field = np.full((20, 30), 1e-4)
    field[:, 11] = 0.0
    return field


def test_a_line_of_contacts_blocks_the_direction_across_it_alone(field):
    assert flow_along(field, "x")[:2] == flow_along(np.zeros((5, 5)), "x")[:2] == (0.0, BLOCKED)
    beside = flow_along(field, "y")
    assert beside.status == FLOWS
    assert beside.hydraulic_aperture == pytest.approx(1e-4 * (29 / 30) ** (1 / 3), rel=1e-12)


def test_one_open_cell_opens_a_line_of_contacts(field):
    field[10, 11] = 1e-4
    assert flow_along(field, "x").hydraulic_aperture > 0.0


def test_a_cell_that_meets_others_at_corners_only_opens_no_line_of_contacts(field):
    field[10, 11] = 1e-4
    field[10, 12] = 0.0  # behind the open cell
    assert flow_along(field, "x")[:2] == (0.0, BLOCKED)


def test_a_flow_that_does_not_balance_or_is_singular_is_not_solved(monkeypatch):
    field = random_field(5)
    found = flow_along(field, "x").imbalance
    with monkeypatch.context() as patched:
        patched.setattr(reynolds, "LARGEST_IMBALANCE", 0.5 * found)
        unbalanced = flow_along(field, "x")

    def singular(*arguments, **settings):
        raise RuntimeError("Factor is exactly singular")

    monkeypatch.setattr(scipy.sparse.linalg, "splu", singular)
    for flow in (unbalanced, flow_along(field, "x")):
        assert flow.status == NOT_SOLVED
        assert np.isnan(flow.hydraulic_aperture)


@pytest.mark.parametrize("cells", [256, pytest.param(512, marks=pytest.mark.slow)])
def test_a_published_flow_with_periodic_sides_is_reproduced(cells):
    flow = flow_along(published_gap(cells), "y", "periodic")
    assert flow.hydraulic_aperture**3 == pytest.approx(PUBLISHED_FLUXES[cells], rel=1e-9)


@pytest.mark.parametrize("sides", ["closed", "periodic"])
@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("contact", [0.0, 0.3])
def test_pressures_and_flow_are_those_of_a_dense_solution(contact, direction, sides):
    """Every other cell is eliminated by hand: the pressures are compared with a plain matrix."""
    field = random_field(6, (9, 7), contact)
    rows = along_first_axis(field / field.max(), direction) ** 3
    cells = np.arange(field.size).reshape(rows.shape)
    matrix, load = np.zeros((field.size, field.size)), np.zeros(field.size)
    along = zip(cells[:-1].flat, cells[1:].flat, strict=True)
    beside = np.roll(cells, -1, axis=1)[:, : None if sides == "periodic" else -1]
    across = zip(cells[:, : beside.shape[1]].flat, beside.flat, strict=True)
    for a, b in (*along, *across):
        one, other = rows.flat[a], rows.flat[b]
        face = 2.0 * one * other / max(one + other, 1e-300)
        matrix[[a, b], [a, b]] += face
        matrix[[a, b], [b, a]] -= face
    for side in (0, -1):
        matrix[cells[side], cells[side]] += 2.0 * rows[side]
    load[cells[0]] = 2.0 * rows[0]
    expected = np.linalg.lstsq(matrix, load, rcond=1e-14)[0].reshape(rows.shape)
    flow = flow_along(field, direction, sides)
    assert flow.status == FLOWS
    assert flow.imbalance < 1e-11
    pressure = along_first_axis(flow.pressure, direction)
    assert np.isnan(pressure[rows == 0.0]).all()
    known = np.isfinite(pressure)
    np.testing.assert_allclose(pressure[known], expected[known], rtol=1e-9)
    outflow = 2.0 * (rows[-1] * expected[-1]).sum() * rows.shape[0] / rows.shape[1]
    assert flow.hydraulic_aperture == pytest.approx(field.max() * np.cbrt(outflow), rel=1e-9)


def test_a_flow_that_narrow_faces_add_to_is_a_lower_bound():
    """A cell of 30 nm is solved, those of 15 nm beside it are left out, as cells of 1 mm adjoin."""
    field = np.full((20, 6), 1e-3)
    field[:, 3] = 15e-9
    field[7, 3] = 30e-9
    flow = flow_along(field, "x")
    assert flow.status == AT_LEAST
    narrow = np.mean(field[:, 3] ** 3) * 6.0  # all of the pressure falls along the narrow cells
    assert flow.hydraulic_aperture < 0.9 * np.cbrt(narrow)
    field[:, 3] = 0.0
    field[7, 3] = 30e-9
    assert flow_along(field, "x").status == FLOWS
    assert flow_along(field, "x").hydraulic_aperture == pytest.approx(flow.hydraulic_aperture)
