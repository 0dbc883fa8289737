"""A QUBO as dimod's binary quadratic model."""

from typing import Any

import numpy as np

from tgvdp.formulations.qubo.qubo import Qubo
from tgvdp.solvers.extras import extra


def bqm_of(qubo: Qubo) -> Any:
    """Copy a QUBO into a ``dimod.BinaryQuadraticModel`` whose variables are the labels, in their order."""
    dimod = extra("dimod", "a binary quadratic model")
    return dimod.BinaryQuadraticModel.from_numpy_vectors(
        np.array(qubo.linear),
        (np.array(qubo.rows), np.array(qubo.cols), np.array(qubo.values)),
        qubo.offset,
        dimod.BINARY,
        variable_order=list(qubo.labels),
    )
