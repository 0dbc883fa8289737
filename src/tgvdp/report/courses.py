"""Speed profiles as a driving course, in the words of that of railtoolkit's TrainRuns.jl where it has any."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from tgvdp.report.profiles import Progress, Written, runs_of

if TYPE_CHECKING:
    from tgvdp.api import SearchResult
    from tgvdp.model.train import Train
    from tgvdp.runs.profile import Profile

#: The id of the run, and columns in SI: resistances are means up to the next row.
COURSE_COLUMNS = (
    "id", "label", "driving_mode", "s", "v", "t", "a", "F_T", "F_R", "R_path", "R_traction", "R_wagons",
)  # fmt: skip
#: So much of the terms that it is the rest of is rounding in the resistance of the line: 0 N where it is level.
_ROUNDING = 1e-12
_MODES = {"traction": "accelerating", "cruising": "cruising", "coasting": "coasting", "braking": "braking"}


def driving_course_csv(result: "SearchResult", written: Written, progress: Progress | None = None) -> str:
    """Profiles as driving courses: F_T is traction alone, and line resistance is what remains of F_R.

    The effort of brakes has no column there; R_traction is the resistance of the whole train, R_wagons 0.
    """
    lines = [",".join(COURSE_COLUMNS)]
    for name, run in runs_of(result, written, progress):
        lines.extend(_course_lines(name, run, result.trip.train))
    return "\n".join(lines) + "\n"


def _course_lines(name: str, run: "Profile", train: "Train") -> Iterator[str]:
    v0, v1 = run.speed_mps[:-1], run.speed_mps[1:]
    step_m = np.diff(run.position_m)
    acceleration = 0.5 * (v1 * v1 - v0 * v0) / step_m
    # Means over the distance at constant acceleration, where v² is linear in position.
    mean_v = (2.0 / 3.0) * (v0 * v0 + v0 * v1 + v1 * v1) / (v0 + v1)
    own_n = train.davis_a_n + train.davis_b_n_per_mps * mean_v + train.davis_c_n_per_mps2 * 0.5 * (v0 * v0 + v1 * v1)
    line_n = run.force_n[:-1] - train.inertia_kg * acceleration - own_n
    terms_n = np.abs(run.force_n[:-1]) + train.inertia_kg * (v0 * v0 + v1 * v1) / step_m + own_n
    line_n[np.abs(line_n) <= _ROUNDING * terms_n] = 0.0
    columns = (acceleration, np.maximum(run.force_n[:-1], 0.0), line_n + own_n, line_n, own_n)
    ended = [np.append(values, 0.0) + 0.0 for values in columns]
    for index, regime in enumerate(run.regime_names):
        a, traction_n, resistance_n, path_n, own = (float(values[index]) for values in ended)
        mode = _mode(regime, a, float(run.force_n[index]), float(run.speed_mps[index]), index == len(v0))
        state = (run.position_m[index], run.speed_mps[index], run.time_s[index])
        numbers = (*state, a, traction_n, resistance_n, path_n, own, 0.0)
        yield f"{name},,{mode}," + ",".join(f"{float(value):.12g}" for value in numbers)


def _mode(regime: str, acceleration_mps2: float, force_n: float, speed_mps: float, last: bool) -> str:
    """TrainRuns' name of what the train does."""
    if last and speed_mps == 0.0:
        return "standstill"
    if regime == "traction" and acceleration_mps2 < 0.0:
        return "diminishing"  # a climb that full traction cannot hold
    if regime == "cruising" and force_n < 0.0:
        return "downhillBraking"
    return _MODES[regime]
