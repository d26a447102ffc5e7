"""Sums over bodies of products of quaternion components, and the exact addition of such sums.

The bodies of a block are added in their order, however they are divided into calls; the sums of blocks are
added as whole numbers, in any order.
"""

import numpy as np

from ..intrinsics import fma, inlined, kernel
from ..layout import LIMB_BITS, LIMB_FIRST, ROW_STRIDE
from ..phase import ROUND

SCALE_0, SCALE_1, SCALE_2 = (2.0 ** (LIMB_FIRST + i * LIMB_BITS) for i in range(3))
P, P2, P4, P8 = (np.uint64(rows * ROW_STRIDE) for rows in (1, 2, 4, 8))


@inlined
def departure(r, q):
    """conj(r) q."""
    w = fma(r[0], q[0], fma(r[1], q[1], fma(r[2], q[2], r[3] * q[3])))
    x = fma(r[0], q[1], fma(-r[1], q[0], fma(-r[2], q[3], r[3] * q[2])))
    y = fma(r[0], q[2], fma(-r[2], q[0], fma(-r[3], q[1], r[1] * q[3])))
    z = fma(r[0], q[3], fma(-r[3], q[0], fma(-r[1], q[2], r[2] * q[1])))
    return w, x, y, z


@kernel
def accumulate(quaternions, reference, sums):
    """Add the products of the components of p = conj(reference) q, over bodies.

    Rows are a constant stride apart, so that the compiler sees that they do not overlap.

    Parameters
    ----------
    quaternions : (4, n, k), k <= ROW_STRIDE
    reference : (4 ROW_STRIDE,), k numbers in each ROW_STRIDE
    sums : (10 ROW_STRIDE,), in the same layout, added to: ww, wx, wy, wz, xx, xy, xz, yy, yz, zz
    """
    for b in range(quaternions.shape[1]):
        for i in range(np.uint64(quaternions.shape[2])):  # unsigned: no test for negative indices
            r = reference[i], reference[i + P], reference[i + P2], reference[i + P2 + P]
            q = quaternions[0, b, i], quaternions[1, b, i], quaternions[2, b, i], quaternions[3, b, i]
            w, x, y, z = departure(r, q)
            sums[i] += w * w
            sums[i + P] += w * x
            sums[i + P2] += w * y
            sums[i + P2 + P] += w * z
            sums[i + P4] += x * x
            sums[i + P4 + P] += x * y
            sums[i + P4 + P2] += x * z
            sums[i + P4 + P2 + P] += y * y
            sums[i + P8] += y * z
            sums[i + P8 + P] += z * z


@kernel
def add_exactly(sums, limbs):
    """Add the sums of a block to whole numbers: exactly, but for digits below the last limb's unit.

    Parameters
    ----------
    sums : (10 ROW_STRIDE,), set to zero
    limbs : (3, 10, k), int64, added to
    """
    for j in range(limbs.shape[1]):
        for i in range(limbs.shape[2]):
            rest = sums[j * ROW_STRIDE + i]
            for limb in range(3):
                scale = SCALE_0 if limb == 0 else (SCALE_1 if limb == 1 else SCALE_2)
                whole = (rest * scale + ROUND) - ROUND
                limbs[limb, j, i] += int(whole)
                rest -= whole / scale
            sums[j * ROW_STRIDE + i] = 0.0
