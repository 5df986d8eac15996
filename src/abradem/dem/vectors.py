"""Vectors of three numbers as tuples, with fused multiply-add.

A fused multiply-add is rounded once and is one processor instruction instead of two. It is called
explicitly: a compiler that is free to fuse operations would do so in some places only, and the
steppings, which share these formulas, would differ in their last bits.
"""

from __future__ import annotations

from numba.core import types
from numba.extending import intrinsic

from abradem.dem.cache import kernel


@intrinsic
def fma(typing_context, a, b, c):
    """Return a b + c, rounded once (IEEE 754 fusedMultiplyAdd)."""

    def codegen(context, builder, signature, arguments):
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), codegen


@kernel(inline=True)
def dot(a, b):
    """Return a . b."""
    return fma(a[0], b[0], fma(a[1], b[1], a[2] * b[2]))


@kernel(inline=True)
def cross(a, b):
    """Return a x b."""
    return (
        fma(a[1], b[2], -(a[2] * b[1])),
        fma(a[2], b[0], -(a[0] * b[2])),
        fma(a[0], b[1], -(a[1] * b[0])),
    )


@kernel(inline=True)
def plus(a, share, b):
    """Return a + share b."""
    return fma(share, b[0], a[0]), fma(share, b[1], a[1]), fma(share, b[2], a[2])


@kernel(inline=True)
def scaled(a, scale):
    """Return scale a."""
    return scale * a[0], scale * a[1], scale * a[2]


@kernel(inline=True)
def split(v, n):
    """Return the component of v along the unit vector n, and v without that component."""
    along = dot(v, n)
    return along, plus(v, -along, n)
