"""Conventions: how a tool reads the same train and line, so that its results can be reproduced.

Sources: TTOBench (Kouzoupis et al., its README files and reference data), OSRD (its documentation of the running-time
calculation), TrainRuns.jl (Kannenberg, TU Dresden; its source of the running-time calculation).
"""

from dataclasses import dataclass, replace
from typing import Any

from tgvdp.constants import (
    CURVE_FORMULAS,
    GRAVITY_MPS2,
    LIMIT_RULES,
    MASS_MODELS,
    STANDARD_GRAVITY_MPS2,
)
from tgvdp.errors import InputError
from tgvdp.model.checks import require_number, require_text


@dataclass(frozen=True, kw_only=True)
class Convention:
    """How line resistance, speed limits and integration are understood.

    Parameters
    ----------
    name : str
        For people.
    gravity_mps2 : float
        Acceleration of gravity.
    mass_model : {"point", "strip"}
        Gradient and curve act at the train's head, or averaged over its length.
    limits : {"head", "tail"}
        A rise of the speed limit counts from where the head, or the tail, has passed it.
    curves : {"none", "800/R", "roeckl"}
        Formula of curve resistance in permille of weight: none; 800/R (OSRD); 650/(R − 55) from 300 m on and
        500/(R − 30) below (Röckl).
    tunnels : bool
        Whether the train's additional drag in tunnels counts.
    step_m : float or None
        Distance step of the explicit integration whose running time is reported beside the converged one.

    Raises
    ------
    InputError
        When a value is unknown or out of range.
    """

    name: str
    gravity_mps2: float = GRAVITY_MPS2
    mass_model: str = "point"
    limits: str = "head"
    curves: str = "none"
    tunnels: bool = False
    step_m: float | None = None

    def __post_init__(self) -> None:
        owner = f"convention {require_text('convention', 'name', self.name)}"
        gravity_mps2 = require_number(owner, "gravity_mps2", self.gravity_mps2, "m/s²", above=0.0)
        object.__setattr__(self, "gravity_mps2", gravity_mps2)
        for field, known in (("mass_model", MASS_MODELS), ("limits", LIMIT_RULES), ("curves", CURVE_FORMULAS)):
            if getattr(self, field) not in known:
                raise InputError(
                    f"{owner}: {field} must be one of {', '.join(known)}, got {getattr(self, field)!r:.60}"
                )
        if self.step_m is not None:
            require_number(owner, "step_m", self.step_m, "m", above=0.0)


TTOBENCH = Convention(name="ttobench")
OSRD = Convention(name="osrd", mass_model="strip", limits="tail", curves="800/R")
#: Its published running times are those of a mass point, its default; the strip model misses that of `slope` by 0.1 s.
TRAINRUNS = Convention(name="trainruns", gravity_mps2=STANDARD_GRAVITY_MPS2, limits="tail", step_m=20.0)

#: Presets by the name that ``--convention`` takes; the first one is the default.
CONVENTIONS = {convention.name: convention for convention in (TTOBENCH, OSRD, TRAINRUNS)}


def convention_of(
    preset: str,
    *,
    mass_model: str | None = None,
    limits: str | None = None,
    curves: str | None = None,
    tunnels: bool | None = None,
) -> Convention:
    """Return a preset, with some of its switches changed.

    Parameters
    ----------
    preset : str
        One of `CONVENTIONS`.
    mass_model, limits, curves, tunnels
        As in `Convention`; None keeps the preset's.

    Raises
    ------
    InputError
        When a name is unknown.
    """
    if preset not in CONVENTIONS:
        raise InputError(f"convention must be one of {', '.join(CONVENTIONS)}, got {preset!r:.60}")
    given: dict[str, Any] = {"mass_model": mass_model, "limits": limits, "curves": curves, "tunnels": tunnels}
    changed = {name: value for name, value in given.items() if value is not None}
    return replace(CONVENTIONS[preset], **changed) if changed else CONVENTIONS[preset]
