"""Interaction of all contacts of a grid: a convolution, Eqs. (17) to (20).

Kernels call `numpy.fft` through rocket-fft, which makes it available in Numba.
"""

import math
from typing import NamedTuple

import numpy as np
import scipy.fft

from jointclosure.compilation.kernels import kernel, large_kernel
from jointclosure.mechanics.interaction import interaction_displacement
from jointclosure.solvers.products import assign, symmetric_times

LARGEST_DENSE = 4000
"""Number of contacts of the largest dense matrix, 128 MB."""
_PATCH, _PATCHES_ACROSS = 7, 20
"""Cells along a patch of the preconditioner, and number of patches along a large grid."""


class Influence(NamedTuple):
    """Displacements by unit forces [m/N] on a grid of (ny, nx) cells.

    ``table`` (ny, nx) is by distance in cells, 0 at distance 0, which is the substrate's term.
    ``spectrum`` (columns // 2 + 1, rows) is its transform, wrapped around a grid without periodic
    images; ``padded``, ``field`` (ny, columns) and ``wave`` are work space. ``patch_table`` is the
    mean influence between patches of ``patch`` cells, ``patch_of`` the patch of each cell.
    """

    table: np.ndarray
    spectrum: np.ndarray
    padded: np.ndarray
    field: np.ndarray
    wave: np.ndarray
    patch: int
    patch_table: np.ndarray
    patch_of: np.ndarray


@kernel
def influence_table(ny, nx, base_radius, substrate_modulus, spacing):
    """Compute displacements per unit force [m/N] at distances of (y, x) cells; 0 at distance 0."""
    table = np.zeros((ny, nx))
    for y in range(ny):
        for x in range(nx):
            if y > 0 or x > 0:
                distance = spacing * np.sqrt(float(y * y + x * x))
                table[y, x] = interaction_displacement(distance, base_radius, substrate_modulus)
    return table


@kernel
def influence_by_place(table):
    """Return influence [m/N] by the difference of two places, flat, and the index of 0."""
    ny, nx = table.shape
    stride = 2 * nx - 1
    wide = np.empty((2 * ny - 1) * stride)
    for y in range(2 * ny - 1):
        for x in range(stride):
            wide[y * stride + x] = table[abs(y - ny + 1), abs(x - nx + 1)]
    return wide, (ny - 1) * stride + nx - 1


@kernel
def places(cells, nx):
    """Return places (n,) of cells (n,) given by flat index, see `influence_by_place`."""
    place = np.empty(cells.size, np.int64)
    for i in range(cells.size):
        y, x = divmod(cells[i], nx)
        place[i] = y * (2 * nx - 1) + x
    return place


@kernel
def fill_influence(matrix, wide, middle, place, known):
    """Fill in influences [m/N] between cells at places (n,), after the first ``known`` ones."""
    n = place.size
    for i in range(known):
        row, at = matrix[i], middle + place[i]
        for j in range(known, n):
            row[j] = wide[at - place[j]]
    for i in range(known, n):
        row, at = matrix[i], middle + place[i]
        for j in range(n):
            row[j] = wide[at - place[j]]


@kernel
def influence_matrix(table, cells):
    """Compute the dense influence matrix (n, n) [m/N] between cells given by flat index."""
    matrix = np.empty((cells.size, cells.size))
    if cells.size == 0:
        return matrix
    wide, middle = influence_by_place(table)
    fill_influence(matrix, wide, middle, places(cells, table.shape[1]), 0)
    return matrix


@kernel
def displacement_between(wide, middle, place, sources, force):
    """Compute displacements (m,) [m] at places (m,) by forces (n,) [N] at ``sources``."""
    answer = np.zeros(place.size)
    for j in range(sources.size):
        if force[j] > 0.0:
            at = middle - sources[j]
            for i in range(place.size):
                answer[i] += wide[at + place[i]] * force[j]
    return answer


class Neighbours:
    """Cells (n,) that overlapped recently, by flat index, and the influence matrix between them.

    Nearly the same cells overlap from round to round, so that rows are added for new cells. If over
    a quarter of it is unused, it is started again. ``matrix`` (m, m) is filled in n rows and
    columns.
    """

    def __init__(self, table: np.ndarray):
        self._table, (self._wide, self._middle) = table, influence_by_place(table)
        self._slot = np.full(table.size, -1)
        self.cells = np.empty(0, np.int64)
        self._place = self.cells
        self.matrix = np.empty((0, 0))

    def slots(self, cells: np.ndarray) -> np.ndarray:
        """Return the indices of the given cells (k,) in `cells`, after adding new ones."""
        slot = self._slot[cells]
        new = cells[slot < 0]
        if self.cells.size + new.size > 1.25 * cells.size:
            self._slot[self.cells] = -1
            self.cells = self._place = self.cells[:0]
            new = cells
        if new.size:
            self._add(new)
            slot = self._slot[cells]
        return slot

    def displacement_at(self, cells: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Compute displacements (k,) [m] at other cells (k,) by forces (n,) [N] at `cells`."""
        place = places(cells, self._table.shape[1])
        return displacement_between(self._wide, self._middle, place, self._place, force)

    def _add(self, new: np.ndarray) -> None:
        known, n = self.cells.size, self.cells.size + new.size
        self._slot[new] = np.arange(known, n)
        self.cells = np.concatenate([self.cells, new])
        self._place = np.concatenate([self._place, places(new, self._table.shape[1])])
        if n > self.matrix.shape[0]:
            room = int(1.3 * n) // 8 * 8 + 8
            larger = np.empty((room, room))
            larger[:known, :known] = self.matrix[:known, :known]
            self.matrix = larger
        fill_influence(self.matrix, self._wide, self._middle, self._place, known)


@kernel
def patch_influence(table, side):
    """Compute mean influence [m/N] between patches of side x side cells, by distance in patches."""
    ny, nx = table.shape
    means = np.zeros(((ny + side - 1) // side, (nx + side - 1) // side))
    for p in range(means.shape[0]):
        for q in range(means.shape[1]):
            for a in range(1 - side, side):
                for b in range(1 - side, side):
                    y, x = min(abs(p * side + a), ny - 1), min(abs(q * side + b), nx - 1)
                    means[p, q] += (side - abs(a)) * (side - abs(b)) * table[y, x]
    return means / float(side) ** 4


@kernel
def set_interaction_field(influence, force):
    """Set `Influence.field` to displacements [m] by forces (y, x) [N], Eqs. (17), (18) summed."""
    ny = force.shape[0]
    padded, wave = influence.padded, influence.wave
    for y in range(ny):
        assign(padded[y], force[y])
    inside = wave[:, :ny].T
    np.fft.rfft(padded, axis=1, out=inside)
    wave[:, ny:] = 0.0
    np.fft.fft(wave, axis=1, out=wave)
    wave *= influence.spectrum
    np.fft.ifft(wave, axis=1, out=wave)
    np.fft.irfft(inside, padded.shape[1], axis=1, out=influence.field)


@kernel
def interaction_field(influence, force):
    """Compute displacements (y, x) [m] by forces (y, x) [N], Eqs. (17) and (18) summed."""
    set_interaction_field(influence, force)
    return influence.field[:, : force.shape[1]].copy()


@large_kernel
def interaction_product(influence, matrix, cells, values, force):
    """Compute displacements (n,) [m] at cells by forces (n,) [N] at the same cells."""
    if matrix.size > 0:
        return symmetric_times(matrix, values)
    flat = force.ravel()
    for i in range(cells.size):
        flat[cells[i]] = values[i]
    set_interaction_field(influence, force)
    nx = force.shape[1]
    answer = np.empty(cells.size)
    for i in range(cells.size):
        answer[i] = influence.field[cells[i] // nx, cells[i] % nx]
    return answer


def mean_displacement(table: np.ndarray) -> np.ndarray:
    """Compute the mean displacement of all cells by a unit force at each (ny, nx) [m/N]."""
    for axis in (0, 1):
        summed = np.cumsum(table, axis)
        first = np.take(table, [0], axis)
        # cells from this one on, and cells before it
        table = summed + np.flip(summed, axis) - first
    return table / table.size


def influence_of(table: np.ndarray) -> Influence:
    """Make the interaction on a grid from its `influence_table` (ny, nx)."""
    ny, nx = table.shape
    rows, columns = (scipy.fft.next_fast_len(2 * n - 1, real=True) for n in table.shape)
    wrapped = np.zeros((rows, columns))
    wrapped[:ny, :nx] = table
    if ny > 1:
        wrapped[1 - ny :, :nx] = table[:0:-1]
    if nx > 1:
        wrapped[:, 1 - nx :] = wrapped[:, nx - 1 : 0 : -1]
    side = max(_PATCH, round(math.sqrt(table.size) / _PATCHES_ACROSS))
    patches = patch_influence(table, side)
    spectrum = np.ascontiguousarray(scipy.fft.rfft2(wrapped, workers=1).T)
    padded, field = np.zeros((2, ny, columns))
    patch_of = (np.arange(ny)[:, None] // side * patches.shape[1] + np.arange(nx) // side).ravel()
    wave = np.empty_like(spectrum)
    return Influence(table, spectrum, padded, field, wave, side, patches, patch_of)


def dense_limit(shape: tuple[int, int]) -> int:
    """Return the number of contacts up to which a dense product is cheaper than a convolution."""
    return min(int(8.0 * math.sqrt(shape[0] * shape[1])), LARGEST_DENSE)


def dense_influence(table: np.ndarray) -> Influence:
    """Make the interaction for few contacts, with cheap dense products: only the table."""
    nothing, wave = np.zeros((0, 0)), np.zeros((0, 0), np.complex128)
    return Influence(table, wave, nothing, nothing, wave, 0, nothing, np.zeros(0, np.int64))
