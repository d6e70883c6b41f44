"""Inner products and linear algebra with the same bits on any processor.

Linear algebra libraries sum in a different order on every kind of processor. The last digit then
differs, and breakage turns this difference into another history. These sums have one order: eight
partial sums, which vector units of any width compute in parallel.
"""

import numpy as np

from jointclosure.compilation.kernels import kernel, large_kernel

PIVOTS = 4  # number of pivots of one pass over a matrix
LANES = 8  # largest number of values in a vector of a processor


@kernel
def assign(target, source):
    """Copy values (n,) into an array (n,), as ``target[:] = source``."""
    for i in range(source.size):
        target[i] = source[i]


@kernel
def inner(one, other):
    """Compute the sum of the products of two arrays (n,)."""
    n = one.size
    s0 = s1 = s2 = s3 = s4 = s5 = s6 = s7 = 0.0
    whole = n - n % 8
    for i in range(0, whole, 8):
        s0 += one[i] * other[i]
        s1 += one[i + 1] * other[i + 1]
        s2 += one[i + 2] * other[i + 2]
        s3 += one[i + 3] * other[i + 3]
        s4 += one[i + 4] * other[i + 4]
        s5 += one[i + 5] * other[i + 5]
        s6 += one[i + 6] * other[i + 6]
        s7 += one[i + 7] * other[i + 7]
    rest = 0.0
    for i in range(whole, n):
        rest += one[i] * other[i]
    return ((s0 + s4) + (s2 + s6)) + ((s1 + s5) + (s3 + s7)) + rest


@kernel
def symmetric_times(matrix, vector):
    """Multiply a symmetric matrix by a vector (n,); return the product (n,).

    The matrix is (n, n), or larger, of which the first n rows and columns are used.
    """
    n = vector.size
    answer = np.zeros(n)
    whole = n - n % 4
    for j in range(0, whole, 4):
        v0 = vector[j]
        v1 = vector[j + 1]
        v2 = vector[j + 2]
        v3 = vector[j + 3]
        r0 = matrix[j]
        r1 = matrix[j + 1]
        r2 = matrix[j + 2]
        r3 = matrix[j + 3]
        for i in range(n):
            answer[i] = answer[i] + r0[i] * v0 + r1[i] * v1 + r2[i] * v2 + r3[i] * v3
    for j in range(whole, n):
        row = matrix[j]
        value = vector[j]
        for i in range(n):
            answer[i] += row[i] * value
    return answer


@large_kernel
def symmetric_inverse(matrix):
    """Invert a symmetric positive definite matrix (n, n) by sweeping pivot by pivot.

    The sweep operator (Goodnight 1979) acts on the lower triangle; a positive definite matrix needs
    no pivoting. `PIVOTS` pivots share one pass over the matrix, with the same operations in the
    same order as pivot by pivot.
    """
    n = matrix.shape[0]
    wide = n + -n % LANES  # whole vectors: what they add to the upper triangle is not used
    swept = np.zeros((n, wide))
    for i in range(n):
        assign(swept[i], matrix[i])
    columns = np.zeros((PIVOTS, wide))
    shares = np.zeros((PIVOTS, wide))
    for first in range(0, n, PIVOTS):
        width = min(PIVOTS, n - first)
        shares[width:] = 0.0
        for q in range(width):
            column = columns[q]
            k = first + q
            assign(column, swept[k, :k])
            assign(column[k:], swept[k:, k])
            _follow_pivots(column, k, first, 0, q, columns, shares)
            for i in range(n):
                shares[q, i] = column[i] / column[k]
        _subtract_products(swept, columns, shares)
        for q in range(width):
            k = first + q
            row = shares[q].copy()
            row[k] = -1.0 / columns[q, k]
            _follow_pivots(row, k, first, q + 1, width, columns, shares)
            assign(swept[k], row[:k])
            assign(swept[k:, k], row[k:n])
    answer = np.empty((n, n))
    for i in range(n):
        for j in range(i + 1):
            answer[i, j] = answer[j, i] = -swept[i, j]
    return answer


@kernel
def _follow_pivots(row, k, first, start, stop, columns, shares):
    """Sweep row k of a symmetric matrix, in place, by the pivots ``start`` to ``stop`` of a pass.

    Pivot r of the pass is row ``first`` + r of the matrix; ``columns`` and ``shares`` hold its
    column, and this over the pivot.
    """
    for r in range(start, stop):
        column = columns[r]
        share = shares[r]
        at_column = column[k]
        at_share = share[k]
        for i in range(k):
            row[i] -= at_share * column[i]
        for i in range(k, row.size):
            row[i] -= share[i] * at_column
        row[first + r] = at_share


@kernel
def _subtract_products(swept, columns, shares):
    """Subtract the products of `PIVOTS` shares and columns, one by one, from a matrix in place.

    Only the lower triangle is used afterwards; part of the upper one is changed too.
    """
    c0 = columns[0]
    c1 = columns[1]
    c2 = columns[2]
    c3 = columns[3]
    for i in range(swept.shape[0]):
        row = swept[i]
        s0 = shares[0, i]
        s1 = shares[1, i]
        s2 = shares[2, i]
        s3 = shares[3, i]
        for j in range(i + LANES - i % LANES):
            row[j] = row[j] - s0 * c0[j] - s1 * c1[j] - s2 * c2[j] - s3 * c3[j]
