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
from tgvdp.formulations.qubo.names import Encoding
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
        One of `ENCODINGS`.
    penalty : float
        λ, weight of a squared violation of 1, in the objective's unit.
    decode : callable
        (n,) bits → Schedule; its checks are those of the instance and, where its bits mean nothing otherwise, those of
        the encoding. Slack bits are not checked: a schedule may keep a limit that its slack register misstates.
    objective, violation : Qubo
        The two parts: qubo = objective + λ · violation, and a violation of 0 where nothing is violated, else ≥ 1 (but
        for the weights of ``tenfold``).
    complete : bool
        Whether every feasible schedule has a string that violates nothing: ``total`` limits on accelerations forbid
        some.
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
    complete: bool = True
    registers: tuple[tuple[int, ...], ...] = ()
