"""Interaction of all contacts of a grid: a convolution, Eqs. (17) to (20).

Kernels call `numpy.fft` through rocket-fft, which makes these functions available in Numba. In this
module a cell is given by its flat index, y nx + x, in a grid (ny, nx).
"""

import math
from typing import NamedTuple

import numpy as np
import scipy.fft

from jointclosure.compilation.kernels import kernel, large_kernel
from jointclosure.mechanics.interaction import interaction_displacement
from jointclosure.solvers.cells import row_of
from jointclosure.solvers.products import assign, symmetric_times

LARGEST_DENSE = 3000
"""Number of contacts of the largest dense matrix, 72 MB: on 512 x 512 cells a convolution is faster
for more (benchmarks/solver_speed.py)."""
FEW_FORCES = 16
"""Number of forces up to which their displacements are added one by one, not by a convolution."""
_PATCH = 7  # least number of cells along a patch of the preconditioner
_PATCHES_ACROSS = 20  # number of patches along a large grid, whose patches are larger


class SingleInfluence(NamedTuple):
    """Interaction of a grid in single precision, with its own work space as in `Influence`."""

    unit: float  # [m/N], a power of 2 that keeps values within the range of single precision
    spectrum: np.ndarray  # transform of the influence, divided by the unit
    padded: np.ndarray
    field: np.ndarray
    wave: np.ndarray


class Influence(NamedTuple):
    """Interaction on a grid of (ny, nx) cells: displacements by unit forces [m/N].

    A convolution pads the grid to (rows, columns), at least 2 ny - 1 and 2 nx - 1, so that it has
    no periodic images.
    """

    table: np.ndarray  # (ny, nx) by distance in cells; 0 at distance 0: see `ContactLaw.substrate`
    spectrum: np.ndarray  # transform of the table (columns // 2 + 1, rows), real by its symmetry
    padded: np.ndarray  # work space: forces (ny, columns)
    field: np.ndarray  # work space: displacements (ny, columns)
    wave: np.ndarray  # work space: transform of the forces, of the shape of the spectrum
    patch: int  # cells along a patch of the preconditioner
    patch_table: np.ndarray  # mean influence [m/N] by distance in patches, of their rows, columns
    patch_of: np.ndarray  # patch of each cell (ny * nx,), a flat index in ``patch_table``
    single: SingleInfluence


@kernel
def influence_table(ny, nx, base_radius, substrate_modulus, spacing):
    """Compute the influence (ny, nx) of a cell [m/N] by distance in cells, Eqs. (17) to (20).

    The influence is the displacement per unit force. It is 0 at distance 0, where the compliance of
    the substrates is part of the contact law. Lengths are in m, the modulus in Pa.
    """
    table = np.zeros((ny, nx))
    for y in range(ny):
        for x in range(nx):
            if y > 0 or x > 0:
                distance = spacing * np.sqrt(float(y * y + x * x))
                table[y, x] = interaction_displacement(distance, base_radius, substrate_modulus)
    return table


@kernel
def influence_by_place(table):
    """Return the influence [m/N] by the difference of two places, a flat array, and its middle.

    A place (`places`) is the number of a cell in rows of 2 nx - 1 cells, so that the difference of
    two places determines the distance of the cells along y and along x. ``table`` (ny, nx) is
    `Influence.table`. The influence between two places is the entry at the middle plus their
    difference.
    """
    ny, nx = table.shape
    stride = 2 * nx - 1
    wide = np.empty((2 * ny - 1) * stride)
    for y in range(2 * ny - 1):
        for x in range(stride):
            wide[y * stride + x] = table[abs(y - ny + 1), abs(x - nx + 1)]
    return wide, (ny - 1) * stride + nx - 1


@kernel
def places(cells, nx):
    """Return the places y (2 nx - 1) + x of cells (n,), numbers in rows of 2 nx - 1 cells."""
    place = np.empty(cells.size, np.int64)
    for i in range(cells.size):
        y, x = divmod(cells[i], nx)
        place[i] = y * (2 * nx - 1) + x
    return place


@kernel
def padded_places(cells, nx, columns):
    """Return the flat indices of cells (n,) in an array whose rows are padded to ``columns``.

    The cells are given by flat index in rows of ``nx`` cells.
    """
    place = np.empty(cells.size, np.int64)
    inverse = 1.0 / nx
    for i in range(cells.size):
        place[i] = cells[i] + row_of(cells[i], inverse) * (columns - nx)
    return place


@kernel
def fill_influence(matrix, wide, middle, place, known):
    """Fill in the influences [m/N] between cells in the first n rows and columns of a matrix.

    ``place`` (n,) are the places of the cells, ``wide`` and ``middle`` are from
    `influence_by_place`. The influences between the first ``known`` cells are in the matrix
    already.
    """
    n = place.size
    for i in range(known):
        row = matrix[i]
        at = middle + place[i]
        for j in range(known, n):
            row[j] = wide[at - place[j]]
    for i in range(known, n):
        row = matrix[i]
        at = middle + place[i]
        for j in range(n):
            row[j] = wide[at - place[j]]


@kernel
def influence_matrix(table, cells):
    """Compute the dense influence matrix (n, n) [m/N] between cells (n,) of a grid."""
    matrix = np.empty((cells.size, cells.size))
    if cells.size == 0:
        return matrix
    wide, middle = influence_by_place(table)
    fill_influence(matrix, wide, middle, places(cells, table.shape[1]), 0)
    return matrix


@kernel
def displacement_between(wide, middle, place, sources, force):
    """Compute displacements (m,) [m] at some places by forces (n,) [N] at other places.

    ``place`` (m,) are the places of the displaced cells, ``sources`` (n,) those of the forces
    (`places`); ``wide`` and ``middle`` are from `influence_by_place`. Forces that are not positive
    are left out, and a force does not displace its own place.
    """
    answer = np.zeros(place.size)
    for j in range(sources.size):
        if force[j] > 0.0:
            at = middle - sources[j]
            for i in range(place.size):
                answer[i] += wide[at + place[i]] * force[j]
    return answer


class RecentContacts:
    """Cells (n,) that overlapped recently, and the influence matrix between them, for one joint.

    ``table`` is that of `Influence`. Nearly the same cells overlap from one equilibrium to the
    next, so that `slots`, which receives the cells that overlap now, computes only the rows and
    columns of new cells. It starts again with these alone if the cells would otherwise be more than
    1.25 times as many. ``matrix`` (m, m) [m/N], m >= n, is filled in its first n rows and columns.
    """

    def __init__(self, table: np.ndarray):
        self._table = table
        self._wide, self._middle = influence_by_place(table)
        self._slot = np.full(table.size, -1)
        self.cells = np.empty(0, np.int64)
        self._place = self.cells
        self.matrix = np.empty((0, 0))

    def slots(self, cells: np.ndarray) -> np.ndarray:
        """Return the indices (k,) of overlapping cells (k,) in `cells`, after adding new ones.

        If `cells` would then have more than 1.25 k entries, it is started again with the given
        cells alone, and indices from earlier calls are no longer valid.
        """
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
        """Compute displacements (k,) [m] at cells (k,) by forces (n,) [N] at the recent contacts.

        Forces that are not positive are left out.
        """
        place = places(cells, self._table.shape[1])
        return displacement_between(self._wide, self._middle, place, self._place, force)

    def _add(self, new: np.ndarray) -> None:
        """Add rows and columns of new cells (k,) to the matrix of the recent contacts.

        If it has too few, a larger matrix takes its place.
        """
        known = self.cells.size
        n = self.cells.size + new.size
        self._slot[new] = np.arange(known, n)
        self.cells = np.concatenate([self.cells, new])
        self._place = np.concatenate([self._place, places(new, self._table.shape[1])])
        if n > self.matrix.shape[0]:
            room = 2 * n // 8 * 8 + 8
            larger = np.empty((room, room))
            larger[:known, :known] = self.matrix[:known, :known]
            self.matrix = larger
        fill_influence(self.matrix, self._wide, self._middle, self._place, known)


@kernel
def patch_influence(table, side):
    """Compute the mean influence [m/N] between square patches, by distance in patches (y, x).

    A patch has ``side`` x ``side`` cells, ``table`` (ny, nx) is `Influence.table`. A patch that
    reaches over the edge of the grid counts as whole; distances beyond the table count as its
    largest.
    """
    ny, nx = table.shape
    means = np.zeros(((ny + side - 1) // side, (nx + side - 1) // side))
    for p in range(means.shape[0]):
        for q in range(means.shape[1]):
            for a in range(1 - side, side):
                for b in range(1 - side, side):
                    y = min(abs(p * side + a), ny - 1)
                    x = min(abs(q * side + b), nx - 1)
                    means[p, q] += (side - abs(a)) * (side - abs(b)) * table[y, x]
    return means / float(side) ** 4


@kernel
def convolve(padded, spectrum, wave, field):
    """Set ``field`` (ny, columns) to the convolution of ``padded`` (ny, columns) with an influence.

    ``spectrum`` is the transform of the influence, ``wave`` work space of its shape, which is
    overwritten. All arrays are in single, or all in double precision.
    """
    ny = padded.shape[0]
    inside = wave[:, :ny].T
    np.fft.rfft(padded, axis=1, out=inside)
    wave[:, ny:] = 0.0
    np.fft.fft(wave, axis=1, out=wave)
    for k in range(wave.shape[0]):
        row = wave[k]
        by = spectrum[k]
        for q in range(row.size):
            row[q] *= by[q]
    np.fft.ifft(wave, axis=1, out=wave)
    np.fft.irfft(inside, padded.shape[1], axis=1, out=field)


@kernel
def set_interaction_field(influence, force):
    """Set `Influence.field` to the displacements [m] by forces (y, x) [N], Eqs. (17), (18) summed.

    The displacements of the cells are in its first nx columns.
    """
    for y in range(force.shape[0]):
        assign(influence.padded[y], force[y])
    convolve(influence.padded, influence.spectrum, influence.wave, influence.field)


@kernel
def interaction_field(influence, force):
    """Compute displacements (y, x) [m] of cells by forces (y, x) [N], Eqs. (17) and (18) summed.

    `Influence.field` is overwritten.
    """
    set_interaction_field(influence, force)
    return influence.field[:, : force.shape[1]].copy()


@large_kernel
def interaction_product(influence, matrix, cells, values, force):
    """Compute displacements (n,) [m] at cells (n,) by forces ``values`` (n,) [N] at the same cells.

    It uses the matrix, unless that is empty. Otherwise it uses a convolution: the values are
    written to ``force`` (y, x) [N], which must be 0 at all other cells, and `Influence.field` gets
    the displacements of all cells.
    """
    if matrix.size > 0:
        return symmetric_times(matrix, values)
    flat = force.ravel()
    for i in range(cells.size):
        flat[cells[i]] = values[i]
    set_interaction_field(influence, force)
    place = padded_places(cells, force.shape[1], influence.field.shape[1])
    field = influence.field.ravel()
    answer = np.empty(cells.size)
    for i in range(cells.size):
        answer[i] = field[place[i]]
    return answer


@large_kernel
def single_product(influence, matrix, cells, values):
    """Compute displacements (n,) [m] at cells by forces at the same cells, in single precision.

    The parameters are those of `interaction_product`. Return the displacements and a unit. With a
    matrix, which is in double precision, the unit is 1. Without one, the unit is in m, and
    `SingleInfluence.field` gets the displacements of all cells divided by it.
    """
    if matrix.size > 0:
        return symmetric_times(matrix, values), 1.0
    single = influence.single
    nx = influence.table.shape[1]
    largest = 0.0
    for i in range(cells.size):
        largest = max(largest, abs(values[i]))
    scale = math.ldexp(1.0, math.frexp(largest)[1]) if 0.0 < largest < math.inf else 1.0
    single.padded[:, :nx] = 0.0
    place = padded_places(cells, nx, single.padded.shape[1])
    padded = single.padded.ravel()
    for i in range(cells.size):
        padded[place[i]] = values[i] / scale
    convolve(single.padded, single.spectrum, single.wave, single.field)
    unit = scale * single.unit
    field = single.field.ravel()
    answer = np.empty(cells.size)
    for i in range(cells.size):
        answer[i] = unit * field[place[i]]
    return answer, unit


@kernel
def add_scaled_displacements(influence, matrix, part, product, unit, displacement):
    """Add the displacements of the last `single_product`, times ``part``, to ``displacement`` [m].

    ``product`` and ``unit`` are what `single_product` returned for this ``influence`` and
    ``matrix``. ``displacement`` is as `Iterate.field`: (1, n) with a matrix, else (y, x); it is
    changed in place.
    """
    if matrix.size > 0:
        for i in range(product.size):
            displacement[0, i] += part * product[i]
        return
    factor = part * unit
    for y in range(displacement.shape[0]):
        row = displacement[y]
        new = influence.single.field[y]
        for x in range(row.size):
            row[x] += factor * new[x]


@large_kernel
def add_displacements(influence, matrix, cells, force, displacement):
    """Add the displacements by forces (n,) [N] at cells (n,) to ``displacement`` [m], in place.

    ``displacement`` is as `Iterate.field`: (1, n) with a matrix, else (y, x). Most of the forces
    are 0. Without a matrix up to `FEW_FORCES` others are added one by one, more by a convolution in
    single precision. Return whether there was a convolution.
    """
    acting = np.flatnonzero(force)
    if matrix.size > 0:
        for j in acting:
            row = matrix[j]
            change = force[j]
            for i in range(cells.size):
                displacement[0, i] += row[i] * change
        return False
    if acting.size > FEW_FORCES:
        product, unit = single_product(influence, matrix, cells[acting], force[acting])
        add_scaled_displacements(influence, matrix, 1.0, product, unit, displacement)
        return True
    ny, nx = displacement.shape
    for j in acting:
        v, w = divmod(cells[j], nx)
        change = force[j]
        for y in range(ny):
            row = displacement[y]
            by = influence.table[abs(y - v)]
            for x in range(w):
                row[x] += by[w - x] * change
            for x in range(w, nx):
                row[x] += by[x - w] * change
    return False


@large_kernel
def add_changes_of_force(influence, cells, start, force, interaction):
    """Change ``interaction`` (y, x) [m], in place, as if ``start`` took the place of ``force``.

    It has the displacements by ``force`` (y, x) [N] before, and afterwards those by the forces
    ``start`` (n,) [N] at the cells (n,) and 0 elsewhere. ``force`` itself is not changed.
    """
    change = -force.ravel()
    for i in range(cells.size):
        change[cells[i]] += start[i]
    every = np.arange(change.size)
    add_displacements(influence, np.empty((0, 0)), every, change, interaction)


def mean_displacement(table: np.ndarray) -> np.ndarray:
    """Compute the mean displacement of all cells [m/N] by a unit force at each cell (ny, nx).

    ``table`` (ny, nx) is `Influence.table`.
    """
    for axis in (0, 1):
        summed = np.cumsum(table, axis)
        first = np.take(table, [0], axis)
        # sums over the cells before and after each cell, and itself once
        table = summed + np.flip(summed, axis) - first
    return table / table.size


def influence_of(table: np.ndarray) -> Influence:
    """Make the interaction on a grid, with its work space, from its `influence_table` (ny, nx)."""
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
    spectrum = np.ascontiguousarray(scipy.fft.rfft2(wrapped, workers=1).T.real)
    padded, field = np.zeros((2, ny, columns))
    patch_of = (np.arange(ny)[:, None] // side * patches.shape[1] + np.arange(nx) // side).ravel()
    wave = np.empty(spectrum.shape, np.complex128)
    patched = side, patches, patch_of
    return Influence(
        table, spectrum, padded, field, wave, *patched, _single_influence(spectrum, padded)
    )


def _single_influence(spectrum: np.ndarray, padded: np.ndarray) -> SingleInfluence:
    """Make `SingleInfluence` of a spectrum [m/N], with work space of the shape of ``padded``."""
    largest = float(np.abs(spectrum).max(initial=0.0))
    unit = math.ldexp(1.0, math.frexp(largest)[1]) if 0.0 < largest < math.inf else 1.0
    cells, field = np.zeros((2, *padded.shape), np.float32)
    wave = np.empty(spectrum.shape, np.complex64)
    return SingleInfluence(unit, (spectrum / unit).astype(np.float32), cells, field, wave)


def dense_limit(shape: tuple[int, int]) -> int:
    """Return the number of contacts up to which a product with a matrix is cheaper.

    Beyond it a convolution on the grid of this shape (ny, nx) is cheaper.
    """
    return min(int(8.0 * math.sqrt(shape[0] * shape[1])), LARGEST_DENSE)


def dense_influence(table: np.ndarray) -> Influence:
    """Make the interaction of few contacts on a grid, which is used with a matrix only.

    It has the table (ny, nx) [m/N] and no memory for convolutions; its other arrays are empty.
    """
    nothing = np.zeros((0, 0))
    wave = np.zeros((0, 0), np.complex128)
    patched = 0, nothing, np.zeros(0, np.int64)
    return Influence(
        table, nothing, nothing, nothing, wave, *patched, _single_influence(nothing, nothing)
    )
