"""Inner products and linear algebra with the same bits on any processor.

Linear algebra libraries sum in a different order on every kind of processor. The last digit then
differs, and breakage turns this difference into another history. These sums have one order: eight
partial sums, which vector units of any width compute in parallel.
"""

import numpy as np

from jointclosure.compilation.kernels import kernel, large_kernel


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
    """Multiply a symmetric matrix (n, n) by a vector (n,): row by row, four at a time."""
    n = vector.size
    answer = np.zeros(n)
    whole = n - n % 4
    for j in range(0, whole, 4):
        v0, v1, v2, v3 = vector[j], vector[j + 1], vector[j + 2], vector[j + 3]
        r0, r1, r2, r3 = matrix[j], matrix[j + 1], matrix[j + 2], matrix[j + 3]
        for i in range(n):
            answer[i] = answer[i] + r0[i] * v0 + r1[i] * v1 + r2[i] * v2 + r3[i] * v3
    for j in range(whole, n):
        row, value = matrix[j], vector[j]
        for i in range(n):
            answer[i] += row[i] * value
    return answer


@large_kernel
def symmetric_inverse(matrix):
    """Invert a symmetric positive definite matrix (n, n) by sweeping pivot by pivot.

    The sweep operator (Goodnight 1979) on the lower triangle needs no pivoting for a positive
    definite matrix.
    """
    n = matrix.shape[0]
    swept = matrix.copy()
    column = np.empty(n)
    for k in range(n):
        column[:k] = swept[k, :k]
        column[k:] = swept[k:, k]
        pivot = column[k]
        for i in range(n):
            share = column[i] / pivot
            row = swept[i]
            for j in range(i + 1):
                row[j] -= share * column[j]
        for i in range(n):
            if i < k:
                swept[k, i] = column[i] / pivot
            elif i > k:
                swept[i, k] = column[i] / pivot
        swept[k, k] = -1.0 / pivot
    for i in range(n):
        for j in range(i + 1):
            swept[i, j] = -swept[i, j]
            swept[j, i] = swept[i, j]
    return swept
