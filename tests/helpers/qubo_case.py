"""QUBOs for tests: small ones with whole numbers, and random ones."""

import itertools

import numpy as np
from hypothesis import strategies as st

from tgvdp.formulations.qubo.qubo import Qubo, QuboBuilder

NUMBERS = st.integers(-9, 9)


@st.composite
def qubos(draw, most=6):
    n = draw(st.integers(0, most))
    pairs = [pair for pair in itertools.combinations(range(n), 2) if draw(st.booleans())]
    rows, cols = zip(*pairs, strict=True) if pairs else ((), ())
    return Qubo(
        np.array(draw(st.lists(NUMBERS, min_size=n, max_size=n))),
        np.array(rows, dtype=np.int32),
        np.array(cols, dtype=np.int32),
        np.array(draw(st.lists(NUMBERS, min_size=len(pairs), max_size=len(pairs)))),
        draw(NUMBERS),
        tuple(f"x{i}" for i in range(n)),
    )


def random_qubo(n, seed):
    rng = np.random.default_rng(seed)
    builder = QuboBuilder(f"x{i}" for i in range(n))
    builder.add_constant(rng.normal())
    builder.add_square({i: float(rng.integers(-3, 4)) for i in range(n)}, 1.0, 0.3)
    for i in range(n):
        builder.add_linear(i, rng.normal())
    return builder.build()
