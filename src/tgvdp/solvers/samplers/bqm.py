"""QUBO ↔ dimod's binary quadratic model."""

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


def qubo_of_bqm(bqm: Any) -> Qubo:
    """Copy a ``dimod.BinaryQuadraticModel`` into a QUBO; its variables become labels by `str`."""
    binary = bqm.change_vartype("BINARY", inplace=False)
    vectors = binary.to_numpy_vectors(variable_order=list(binary.variables), sort_indices=True)
    return Qubo(
        vectors.linear_biases,
        vectors.quadratic.row_indices,
        vectors.quadratic.col_indices,
        vectors.quadratic.biases,
        float(vectors.offset),
        tuple(str(name) for name in binary.variables),
    )
