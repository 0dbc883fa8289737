"""What a driver does along a run: a few steps, from one place to the next."""

from typing import NamedTuple

import numpy as np

from tgvdp.runs.profile import REGIMES, Profile

#: Steps that last shorter than this, s, are no step of their own: nobody could follow them.
LEAST_STEP_S = 3.0
#: What is done in each regime, in their order.
ACTIONS = ("power", "hold", "coast", "brake")


class Instruction(NamedTuple):
    """One step of a driver.

    Attributes
    ----------
    action : str
        ``power``: full traction; ``hold`` the speed; ``coast``; ``brake``.
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
        Shorter phases, s, become part of the ones beside them.

    Returns
    -------
    tuple of Instruction
        In order; each begins where the one before it ends, and no two neighbours have the same action.
    """
    changes = np.flatnonzero(np.diff(profile.regime[:-1])) + 1
    begins = [0, *changes.tolist()]
    steps = [(int(profile.regime[row]), row) for row in begins]
    end = len(profile.time_s) - 1
    while len(steps) > 1:
        lasts_s = np.diff([profile.time_s[row] for _, row in steps], append=profile.time_s[end])
        shortest = int(np.argmin(lasts_s))
        if lasts_s[shortest] >= least_s:
            break
        steps = _without(steps, shortest, lasts_s.tolist())
    rows = [*(row for _, row in steps), end]
    return tuple(
        Instruction(
            ACTIONS[regime], *(float(column[row]) for column in (profile.position_m, profile.time_s, profile.speed_mps)
                               for row in (first, last)),
        )
        for (regime, _), first, last in zip(steps, rows[:-1], rows[1:], strict=True)
    )  # fmt: skip


def _without(steps: list[tuple[int, int]], at: int, lasts_s: list[float]) -> list[tuple[int, int]]:
    """Steps, (regime, first row), without one, which becomes part of the longer of its neighbours."""
    before = lasts_s[at - 1] if at > 0 else -1.0
    after = lasts_s[at + 1] if at + 1 < len(steps) else -1.0
    kept = list(steps)
    if after > before:
        kept[at + 1] = (steps[at + 1][0], steps[at][1])
    del kept[at]
    return [step for index, step in enumerate(kept) if index == 0 or step[0] != kept[index - 1][0]]


assert len(ACTIONS) == len(REGIMES)
