"""What every encoding hands over: an instance as a QUBO, and how to read its strings.

``decode`` turns any bit string, feasible or not, into a `Schedule` that says how far each constraint is violated; the
energy of a string without violation is the schedule's objective, in the same unit.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tgvdp.formulations.problem.instances import BinaryInstance
from tgvdp.formulations.problem.schedule import Schedule
from tgvdp.formulations.qubo.names import Encoding, Weights
from tgvdp.formulations.qubo.qubo import Qubo

Bits: TypeAlias = NDArray[np.integer[Any]]


@dataclass(frozen=True)
class Encoded:
    """An instance as a QUBO.

    Attributes
    ----------
    qubo : Qubo
        In the objective's unit: of a string that violates nothing, its energy is the schedule's objective.
    instance : BinaryInstance
    encoding : str
        As `tgvdp.formulations.qubo.names.parse_encoding` writes it.
    penalty : float
        λ, weight of a squared violation of 1, in the objective's unit.
    decode : callable
        (n,) bits → Schedule; its checks are those of the instance and, where its bits mean nothing otherwise, those of
        the encoding. Slack bits are not checked: a schedule may keep a limit that its slack register misstates.
    objective, violation : Qubo
        The two parts: qubo = objective + λ · violation, and a violation of 0 where nothing is violated, else ≥ the
        least of the weights.
    weights : Weights
        Of the kinds of violations, within ``violation``.
    complete : bool
        Whether every feasible schedule has a string that violates nothing and whose energy is its objective: ``total``
        limits on accelerations forbid some, and the ``cubic`` objective is another one.
    registers : tuple of tuple of int
        Bits of the unary registers, the lowest level first, and bits that stand alone; empty where there are none.
    """

    qubo: Qubo
    instance: BinaryInstance
    encoding: Encoding
    penalty: float
    decode: Callable[[Bits], Schedule] = field(repr=False)
    objective: Qubo = field(repr=False)
    violation: Qubo = field(repr=False)
    weights: Weights
    complete: bool = True
    registers: tuple[tuple[int, ...], ...] = ()
