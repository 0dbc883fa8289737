"""Random trips whose neutral sections lie on descents: ``python -m benchmarks.proof --trips descents``.

The trains return energy, the dynamic brake cannot hold all descents, and running times go far beyond the fastest: what
a train does before and behind a section decides what it returns, and net energies are small.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.proof.trips import (
    KINDS,
    ProofTrip,
    climbable_permil,
    end_speeds,
    even,
    holdable_permil,
    neutral_sections,
    random_limits,
    random_train,
)
from tgvdp.model.track import Gradient, Track
from tgvdp.model.train import Train

#: Gradients of descents, ‰, and their share of the stretches of a line.
_DOWN_PERMIL, _DOWN_SHARE = (5.0, 28.0), 0.6
#: Largest running-time supplements.
_MARGINS = (0.2, 0.8)
_MOST_SECTIONS = 4


def descent_trip(seed: int) -> ProofTrip:
    """Draw the trip of a seed."""
    rng = np.random.default_rng([seed, 0x64657363])
    name = str(rng.choice(list(KINDS)))
    kind = KINDS[name]
    train, shape, brakes = random_train(rng, name, kind)
    while not train.braking.table[:, 1:].any():
        train, shape, brakes = random_train(rng, name, kind)
    train = replace(train, regeneration_efficiency=float(rng.choice([0.5, 0.8, 0.9])))
    length_m = 1e3 * float(np.exp(rng.uniform(*np.log(kind.length_km))))
    limits = tuple(random_limits(rng, kind, train.max_speed_mps, length_m))
    track = Track(length_m=length_m, speed_limits=limits, gradients=_gradients(rng, train, length_m))
    sections = neutral_sections(rng, train, track, _on_descents(rng, track))
    options = {"energy": "pantograph", "max_margin": even(rng, _MARGINS)} | end_speeds(rng, train, track)
    track = replace(track, neutral_sections=sections)
    return ProofTrip(seed, name, f"{shape}, {brakes}, {len(sections)} neutral on descents", train, track, options)


def _gradients(rng: np.random.Generator, train: Train, length_m: float) -> tuple[Gradient, ...]:
    """Descents that the train can hold, with level stretches and climbs between them."""
    least, most = np.minimum(_DOWN_PERMIL, holdable_permil(train))
    up = min(15.0, climbable_permil(train))
    every_m = max(float(rng.choice([300.0, 1000.0, 2500.0, 6000.0])), length_m / 500.0)
    rows, x_m = [], 0.0
    while x_m < length_m:
        falls = rng.random() < _DOWN_SHARE
        permil = -rng.uniform(least, most) if falls else float(rng.choice([0.0, rng.uniform(0.0, up)]))
        rows.append(Gradient(x_m, round(permil, 2)))
        x_m += float(rng.exponential(every_m)) + 20.0
    return tuple(rows)


def _on_descents(rng: np.random.Generator, track: Track) -> NDArray[np.float64]:
    """Up to four increasing positions on descents, m."""
    ends_m = [*(row.position_m for row in track.gradients[1:]), track.length_m]
    falls = [
        (max(row.position_m, 0.05 * track.length_m), min(end_m, 0.95 * track.length_m))
        for row, end_m in zip(track.gradients, ends_m, strict=True)
        if row.gradient_permil < 0.0
    ]
    falls = [(from_m, to_m) for from_m, to_m in falls if to_m > from_m]
    if not falls:
        return np.empty(0)
    lengths_m = np.array([to_m - from_m for from_m, to_m in falls])
    count = min(int(rng.integers(1, _MOST_SECTIONS + 1)), len(falls))
    chosen = rng.choice(len(falls), count, replace=False, p=lengths_m / math.fsum(lengths_m))
    return np.sort([float(rng.uniform(*falls[index])) for index in chosen])
