"""What a driver does along a run: a few steps, from one place to the next."""

from itertools import groupby, zip_longest
from typing import NamedTuple

import numpy as np

from tgvdp.physics.codes import HOLDING
from tgvdp.runs.profile import REGIMES, Profile
from tgvdp.units import mps_to_kmh

#: Steps that last shorter than this, s, are no step of their own: nobody could follow them.
LEAST_STEP_S = 3.0
#: A speed that changes by more than this, km/h, is not held.
_DRIFTS_KMH = 3.0
#: So many short phases in a row are partial effort, by switching.
_PULSES = 4
#: What is done in each regime.
_ACTIONS = {"traction": "power", "cruising": "hold", "coasting": "coast", "braking": "brake"}


class Instruction(NamedTuple):
    """One step of a driver.

    Attributes
    ----------
    action : str
        ``power``: full traction; ``hold`` the speed; ``partial`` effort, by which the speed changes; ``coast``;
        ``brake``.
    from_m, to_m : float
        Positions on the line at which it begins and ends, m.
    from_s, to_s : float
        The same in time since departure, s.
    from_mps, to_mps : float
        Speeds there, m/s.
    """

    action: str
    from_m: float
    to_m: float
    from_s: float
    to_s: float
    from_mps: float
    to_mps: float


def instructions_of(profile: Profile, least_s: float = LEAST_STEP_S) -> tuple[Instruction, ...]:
    """Steps that a driver takes to follow a run.

    Parameters
    ----------
    profile : Profile
    least_s : float
        Shorter phases, s, become part of the ones beside them; many in a row are a speed that is held.

    Returns
    -------
    tuple of Instruction
        In order; each begins where the one before it ends, and no two neighbours have the same action.
    """
    rows, end = [0, *(np.flatnonzero(np.diff(profile.regime[:-1])) + 1).tolist()], len(profile.time_s) - 1
    lasts_s = np.diff(profile.time_s[[*rows, end]]).tolist()
    phases = list(map(_Phase, profile.regime[rows].tolist(), rows, lasts_s))
    steps = _without_short(_without_pulses(phases, least_s), least_s)
    ends = [*(step.row for step in steps[1:]), end]
    columns = (profile.position_m, profile.time_s, profile.speed_mps)
    told = (
        Instruction(
            _ACTIONS[REGIMES[step.regime]], *(float(column[row]) for column in columns for row in (step.row, last))
        )
        for step, last in zip(steps, ends, strict=True)
    )
    return tuple(step._replace(action="partial") if _drifts(step) else step for step in told)


def _drifts(step: Instruction) -> bool:
    """Whether the speed of a step that would hold it changes too much for that."""
    return step.action == "hold" and abs(mps_to_kmh(step.to_mps - step.from_mps)) > _DRIFTS_KMH


class _Phase(NamedTuple):
    """A regime, the row with which it begins, and how long it lasts, s."""

    regime: int
    row: int
    lasts_s: float


def _without_pulses(phases: list[_Phase], least_s: float) -> list[_Phase]:
    """Phases with one that holds in place of many short ones: partial effort by switching."""
    made: list[_Phase] = []
    for is_short, group in groupby(phases, lambda phase: phase.lasts_s < least_s):
        found = list(group)
        if is_short and len(found) >= _PULSES:
            found = [_Phase(HOLDING, found[0].row, sum(phase.lasts_s for phase in found))]
        made += found
    return made


def _without_short(phases: list[_Phase], least_s: float) -> list[_Phase]:
    """Phases with each short one in the longer of its neighbours, and those of one kind that then meet in one."""
    steps: list[_Phase] = []
    left_row, left_s = 0, 0.0  # what goes to the next phase
    for phase, after in zip_longest(phases, phases[1:]):
        lasts_s = left_s + phase.lasts_s
        row, left_s = left_row if left_s else phase.row, 0.0
        joins = bool(steps) and steps[-1].regime == phase.regime
        if lasts_s < least_s and not joins:
            joins = bool(steps) and (after is None or steps[-1].lasts_s >= after.lasts_s)
            if not joins and after is not None:
                left_row, left_s = row, lasts_s
                continue
        if joins:
            steps[-1] = steps[-1]._replace(lasts_s=steps[-1].lasts_s + lasts_s)
        else:
            steps.append(_Phase(phase.regime, row, lasts_s))
    return steps
