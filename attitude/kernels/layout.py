"""What kernels and their callers agree on: the record of a body's constants, and the codes in it.

Plain numpy: who only calls kernels needs no compiler.
"""

from typing import NamedTuple

import numpy as np

CONSTANT_RATE, SHORT_AXIS, LONG_AXIS, SEPARATRIX = range(4)
REGIMES = ("constant_rate", "short_axis", "long_axis", "separatrix")
THETA, TRANSFORMED = range(2)

# What every file of machine code calls its one function, of the address of its arguments' words.
ENTRY = "attitude_entry"


class CompiledName(NamedTuple):
    """Which kernel, for arguments of which kinds, and the digest of all that its machine code depends on.

    A kind is "f" (float), "i" (int), "n" (None), or element and dimensions of a C-ordered array:
    "d2" doubles, "b1" booleans, "r1" records of INVARIANTS.
    """

    module: str
    kernel: str
    kinds: tuple[str, ...]
    digest: str

    def __str__(self) -> str:
        return f"{self.module}.{self.kernel}-{'.'.join(self.kinds)}-{self.digest}.o"

    @classmethod
    def parse(cls, text: str) -> "CompiledName":
        function, kinds, digest = text.removesuffix(".o").split("-")
        module, kernel = function.split(".")
        return cls(module, kernel, tuple(kinds.split(".")), digest)


# Whole turns are dropped in one step; up to this many, what is left lies where the polynomials hold.
MAX_TURNS = 2.0**42


def workspace():
    """Scratch for exact sums: the sum, two generations of a product, its factors; a tensor over a rate.

    Kernels allocate nothing: each call is handed its own.
    """
    return np.empty(512), np.empty((2, 256)), np.empty((5, 2)), np.empty((4, 3))


INVARIANTS = np.dtype(
    [
        # what the samples need
        ("route", "i8"),  # THETA or TRANSFORMED
        ("precession", "f8", 2),  # lambda, turns/s, two parts
        ("argument", "f8", 2),  # v' turns/s, or y' rad/s, two parts
        ("argument0", "f8", 2),  # its value at t = 0
        ("half_turn", "f8", 2),  # y for half a polhode period; infinite on the separatrix
        ("per_half_turn", "f8"),
        ("slip", "f8"),  # turns of precession for each unit of y
        ("nome", "f8"),  # q, or Q of the transformed series
        ("alpha_re", "f8", 4),
        ("alpha_im", "f8", 4),
        ("beta_re", "f8", 4),
        ("beta_im", "f8", 4),
        ("direction", "f8", (4, 5)),  # gamma1, gamma2, gamma3 over the last row; or three factors
        ("frame", "f8", (4, 4)),  # q_IM * . * q_PB
        ("rate", "f8", (3, 3)),  # gamma -> body rate, rad/s
        # what users ask about
        ("regime", "i8"),
        ("amplitude", "f8", 3),  # A1, A2, A3
        ("modulus", "f8"),  # k
        ("complementary_modulus", "f8"),  # k1
        ("K", "f8"),
        ("K_prime", "f8"),
        ("eta", "f8"),
        ("u_rate", "f8"),  # u', rad/s
        ("u0", "f8"),
    ]
)
