"""Figures of trains and lines: those that an engineer checks first, and those that have a usual range.

Ranges span heavy freight to high speed, metros and trams. They warn, and never refuse: unusual is not wrong.

Sources: Wende, Fahrdynamik des Schienenverkehrs (2003), for specific resistance, rotating masses and effort; Curtius
and Kniffler (1944) for adhesion at standstill, 0.33 on dry rail; Commission Regulations (EU) 1299/2014 (INF TSI:
gradients up to 35 ‰, radii from 150 m, cant and deficiency) and 1302/2014 (LOC&PAS TSI: braking); EN 15528 for mass per
metre; published figures of TGV, ICE 3, KISS, metros and ore trains for power, top speed and acceleration.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import pairwise
from operator import neg
from typing import NamedTuple

import numpy as np

from tgvdp.constants import GRAVITY_MPS2
from tgvdp.model.effort import EffortCurve
from tgvdp.model.track import Track
from tgvdp.model.train import Train
from tgvdp.units import KILO, kmh_to_mps, mps_to_kmh

#: What a line without a limit has, as railML writes it.
_NO_LIMIT_KMH = 999.9
_SPEEDS = 2000
#: Effort may rise by so much of its largest before that is odd.
_RISE = 0.05
#: Rows of a line that are named one by one, at most.
_MOST_ROWS = 5
#: Usual ranges of the rows of a line. INF TSI: 35 ‰, mountain lines with adhesion up to 70 ‰; 150 m, metros down to
#: some 60 m; 160 mm of cant and 300 mm of deficiency (tilting trains) over 1500 mm: 3.0 m/s². Metro tubes of 15 m² to
#: double-track tunnels for high speed of 100 m².
_LIMIT_KMH, _GRADIENT_PERMIL, _RADIUS_M = (10.0, 400.0), (-45.0, 45.0), (150.0, 50_000.0)
_LATERAL_MPS2, _TUNNEL_M2 = (0.0, 3.0), (12.0, 150.0)


class Figure(NamedTuple):
    """One figure.

    Attributes
    ----------
    name : str
    value : float or str
        Text where it is a range or a name.
    unit : str
    low, high : float
        Usual range, ends included, of one that is held against it.
    field : str
        Field of the model that such a one comes from, such as ``speed_limits[3]``: where to look in the file.
    hint : str
        What is the likeliest slip when the value lies outside.
    is_headline : bool
        Whether people look at it first.
    """

    name: str
    value: float | str
    unit: str
    low: float = -math.inf
    high: float = math.inf
    field: str = ""
    hint: str = ""
    is_headline: bool = True

    @property
    def ok(self) -> bool:
        """Whether the value lies in the usual range."""
        return isinstance(self.value, str) or self.low <= self.value <= self.high

    def __str__(self) -> str:
        value = self.value if isinstance(self.value, str) else f"{self.value:.6g}"
        return f"{value} {self.unit}".strip()


#: One that only has a usual range.
Check = partial(Figure, is_headline=False)


def train_figures(train: Train) -> Iterator[Figure]:
    """Figures of a train."""
    mass_t, weight_kn = train.mass_kg / KILO, train.mass_kg * GRAVITY_MPS2 / KILO
    has_top = math.isfinite(train.max_speed_mps)
    top_mps = _top_mps(train)
    yield Figure("mass", mass_t, "t", 10.0, 40_000.0, "mass_kg", "t or kg?")
    # Wende: 1.03 (loaded wagons) to 1.3 (electric locomotives).
    slip = "rotating masses left out?" if train.rotating_mass_factor < 1.02 else "percent or factor?"
    yield Figure("rotating mass factor", train.rotating_mass_factor, "", 1.02, 1.35, "rotating_mass_factor", slip)
    # EN 15528 ends at 8.8 t/m, ore lines at some 13 t/m.
    if train.length_m:
        yield Figure("length", train.length_m, "m")
        yield Check("mass per length", mass_t / train.length_m, "t/m", 0.5, 14.0, "length_m", "t or kg, m or km?")
    yield Figure("top speed", mps_to_kmh(top_mps), "km/h", 20.0, 400.0, "max_speed_mps",
                 "m/s given as km/h?" if top_mps < kmh_to_mps(20.0) else "km/h given as m/s?", has_top)  # fmt: skip
    yield from _traction(train, top_mps, has_top)
    # Wende: 1 ‰ (heavy wagons) to 4 ‰ (light multiple units) at low speed, trams more.
    yield Check("rolling resistance", train.davis_a_n / weight_kn, "‰", 0.4, 12.0, "davis_a_n", "N or kN?")
    # Quadratic term ½·ρ·cw·A: 3 N/(m/s)² (a streamlined railcar) to 100 (a kilometre of empty wagons).
    yield Check("quadratic resistance", train.davis_c_n_per_mps2, "N/(m/s)²", 2.0, 150.0, "davis_c_n_per_mps2",
                "km/h or m/s (a factor of 13), N or kN?")  # fmt: skip
    # 3 ‰ (freight at 80 km/h) to 20 ‰ (high speed at 300 km/h), short railcars more.
    top_kn = train.resistance_n(top_mps) / KILO
    yield Figure("resistance at top speed", top_kn, "kN", is_headline=has_top)
    yield Check("resistance at top speed", KILO * top_kn / weight_kn, "‰", 1.0, 50.0, "resistance",
                "km/h or m/s, N or kN?")  # fmt: skip
    yield from _braking(train)
    yield from _efficiency(train)


def _top_mps(train: Train) -> float:
    return train.max_speed_mps if math.isfinite(train.max_speed_mps) else kmh_to_mps(_NO_LIMIT_KMH)


def _traction(train: Train, top_mps: float, has_top: bool) -> Iterator[Figure]:
    start_n = train.traction_limit.effort_n(0.0)
    power_w, at_mps = _largest_power(train.traction, top_mps)
    yield Figure("power at the wheel", power_w / KILO, "kW", is_headline=has_top)
    # 0.5 W/kg (ore trains) to 25 W/kg (high speed), metros up to 30.
    yield Figure("power to mass", power_w / train.mass_kg, "W/kg", 0.3, 40.0, "traction", "kW or W, t or kg?", has_top)
    yield Figure("starting effort", start_n / KILO, "kN")
    # 0.33 is the adhesion of dry rail with every axle driven; wheel slide control reaches 0.4.
    yield Check("starting effort to weight", start_n / (train.mass_kg * GRAVITY_MPS2), "", 0.003, 0.4, "traction",
                "N or kN?")  # fmt: skip
    start_mps2 = min((start_n - train.davis_a_n) / train.inertia_kg, train.max_acceleration_mps2)
    yield Figure("starting acceleration", start_mps2, "m/s²", 0.02, 1.6, "traction", "N or kN, t or kg?")
    share = balancing_speed_mps(train) / top_mps
    yield Check("balancing speed", 100.0 * share, "% of top speed", 80.0, 100.0, "traction",
                f"traction meets the resistance on level track at {mps_to_kmh(share * top_mps):.4g} km/h")  # fmt: skip
    end_w = train.traction.effort_n(top_mps) * top_mps
    yield Check("power at top speed", 100.0 * end_w / power_w, "% of the largest", 30.0, 100.0, "traction",
                f"the largest power is at {mps_to_kmh(at_mps):.4g} km/h: does the curve end too soon?")  # fmt: skip
    yield Check("rise of effort with speed", 100.0 * _rise(train.traction, top_mps), "% of the largest", 0.0,
                100.0 * _RISE, "traction", "speed and effort swapped?")  # fmt: skip


def balancing_speed_mps(train: Train) -> float:
    """Least speed from which on traction is below the resistance on level track, or the top speed, m/s."""
    top_mps = _top_mps(train)
    speeds_mps: list[float] = np.linspace(0.0, top_mps, _SPEEDS + 1).tolist()

    def surplus_n(speed_mps: float) -> float:
        return train.traction_limit.effort_n(speed_mps) - train.resistance_n(speed_mps)

    for low_mps, high_mps in pairwise(speeds_mps):
        if surplus_n(high_mps) < 0.0:
            for _ in range(50):
                middle_mps = 0.5 * (low_mps + high_mps)
                low_mps, high_mps = (middle_mps, high_mps) if surplus_n(middle_mps) >= 0.0 else (low_mps, middle_mps)
            return low_mps
    return top_mps


def _largest_power(curve: EffortCurve, top_mps: float) -> tuple[float, float]:
    speeds_mps = [piece.from_mps for piece in curve.pieces if piece.from_mps <= top_mps]
    speeds_mps += np.linspace(0.0, top_mps, _SPEEDS + 1).tolist()
    return max((curve.effort_n(speed_mps) * speed_mps, speed_mps) for speed_mps in speeds_mps)


def _rise(curve: EffortCurve, top_mps: float) -> float:
    """Largest rise of the effort above what it was at a lower speed, as a share of its largest."""
    efforts_n = np.array([curve.effort_n(speed_mps) for speed_mps in np.linspace(0.0, top_mps, _SPEEDS + 1)])
    return float(np.max(efforts_n - np.minimum.accumulate(efforts_n)) / np.max(efforts_n))


def _braking(train: Train) -> Iterator[Figure]:
    """Full braking on level track: LOC&PAS TSI has 0.5 to 1.5 m/s², freight in position G less, trams up to 2.8."""
    if train.braking_rates:
        slowest = min(train.braking_rates, key=lambda rate: rate.deceleration_mps2)
        rate_mps2, field = slowest.deceleration_mps2, "braking_rates"
        yield Figure("full braking", value_range([rate.deceleration_mps2 for rate in train.braking_rates]), "m/s²")
    else:
        force_n = train.friction_brake_n + train.braking.largest_n(_top_mps(train))
        rate_mps2, field = force_n / train.inertia_kg, "friction_brake_n"
        yield Figure("friction brake", train.friction_brake_n / KILO, "kN")
    rate_mps2 = min(rate_mps2, train.max_deceleration_mps2)
    hint = "this train has no brake" if rate_mps2 == 0.0 else "N or kN, t or kg?"
    yield Check("full braking", rate_mps2, "m/s²", 0.1, 3.0, field, hint)


def _efficiency(train: Train) -> Iterator[Figure]:
    # 1 means that nothing is known: the energy at the wheel alone counts.
    if train.traction_efficiency < 1.0:
        yield Check("traction efficiency", 100.0 * train.traction_efficiency, "%", 50.0, 97.0, "traction_efficiency",
                    "percent or ratio?")  # fmt: skip
    if train.regeneration_efficiency > 0.0:
        yield Check("regeneration efficiency", 100.0 * train.regeneration_efficiency, "%", 30.0, 97.0,
                    "regeneration_efficiency", "percent or ratio?")  # fmt: skip
    if train.auxiliary_power_w > 0.0:
        yield Check("auxiliary power to mass", train.auxiliary_power_w / train.mass_kg, "W/kg", 0.01, 5.0,
                    "auxiliary_power_w", "kW or W?")  # fmt: skip


def track_figures(track: Track) -> Iterator[Figure]:
    """Figures of a line; of rows that have a usual range only those that are unusual, and the extreme ones."""
    limits_kmh = [mps_to_kmh(row.speed_mps) for row in track.speed_limits]
    yield Figure("length", track.length_m / KILO, "km", 0.2, 5000.0, "length_m", "m or km?")
    yield Figure("stops", float(len(track.stops_m)), "")
    yield Figure("speed limits", f"{len(limits_kmh)}, {value_range(limits_kmh)}", "km/h")
    yield from _limits(track)
    if track.gradients:
        permil = [row.gradient_permil for row in track.gradients]
        yield Figure("gradients", f"{len(permil)}, {value_range(permil)}", "‰")
        yield Figure("net height", _net_height_m(track), "m")
        yield from _gradients(track)
    if track.curves:
        radii_m = [abs(radius_m) for row in track.curves for radius_m in row[1:]]
        tightest = (f"tightest {min(radii_m):.6g}", "m") if min(radii_m) < math.inf else ("straight", "")
        yield Figure("curves", f"{len(track.curves)}, {tightest[0]}", tightest[1])
        yield from _curves(track)
    for name in ("tunnels", "neutral_sections"):
        lengths_m = [one.length_m for one in getattr(track, name)]
        if lengths_m:
            yield Figure(name.removesuffix("_sections"), f"{len(lengths_m)}, together {sum(lengths_m):.6g}", "m")
    yield from _tunnels(track)


def _telling(values: Sequence[float], usual: tuple[float, float], extreme: Callable[[float], float] = abs) -> list[int]:
    """Where the first of the unusual values are, or else the most extreme one: a line may have 100,000 rows."""
    low, high = usual
    odd = [index for index, value in enumerate(values) if not low <= value <= high]
    return odd[:_MOST_ROWS] or sorted(range(len(values)), key=lambda index: extreme(values[index]))[-1:]


def _is_limited(speed_mps: float) -> bool:
    return abs(mps_to_kmh(speed_mps) - _NO_LIMIT_KMH) > 1e-6 * _NO_LIMIT_KMH


def _limits(track: Track) -> Iterator[Figure]:
    rows = [(index, row) for index, row in enumerate(track.speed_limits) if _is_limited(row.speed_mps)]
    limits_kmh = [mps_to_kmh(row.speed_mps) for _, row in rows]
    for at in _telling(limits_kmh, _LIMIT_KMH):
        index, row = rows[at]
        hint = "m/s given as km/h?" if limits_kmh[at] < _LIMIT_KMH[0] else "km/h given as m/s?"
        name = f"speed limit at {row.position_m:.6g} m"
        yield Check(name, limits_kmh[at], "km/h", *_LIMIT_KMH, f"speed_limits[{index}]", hint)
    if rows:
        fastest_kmh = max(limits_kmh)
        index, _ = rows[limits_kmh.index(fastest_kmh)]
        yield Check("highest speed limit", fastest_kmh, "km/h", 30.0, 400.0, f"speed_limits[{index}]",
                    "m/s given as km/h?")  # fmt: skip


def _gradients(track: Track) -> Iterator[Figure]:
    permil = [row.gradient_permil for row in track.gradients]
    for index in _telling(permil, _GRADIENT_PERMIL):
        name = f"gradient at {track.gradients[index].position_m:.6g} m"
        yield Check(name, permil[index], "‰", *_GRADIENT_PERMIL, f"gradients[{index}]",
                    "degrees or per cent of something?")  # fmt: skip
    steepest = max(map(abs, permil))
    if steepest > 0.0:
        index = next(i for i, value in enumerate(permil) if abs(value) == steepest)
        yield Check("steepest gradient", steepest, "‰", 0.2, 45.0, f"gradients[{index}]",
                    "metre per metre, or per cent?" if steepest < 1.0 else "tenths of ‰?")  # fmt: skip


def _curves(track: Track) -> Iterator[Figure]:
    radii_m = [min(abs(curve.radius_start_m), abs(curve.radius_end_m)) for curve in track.curves]
    bent = [index for index, radius_m in enumerate(radii_m) if math.isfinite(radius_m)]
    for at in _telling([radii_m[index] for index in bent], _RADIUS_M, neg):
        index = bent[at]
        name = f"radius at {track.curves[index].position_m:.6g} m"
        yield Check(name, radii_m[index], "m", *_RADIUS_M, f"curves[{index}]", "m or km?")
    fast = [(index, _limit_at(track, track.curves[index].position_m)) for index in bent]
    fast = [(index, speed_mps) for index, speed_mps in fast if _is_limited(speed_mps)]
    lateral_mps2 = [speed_mps**2 / radii_m[index] for index, speed_mps in fast]
    for at in _telling(lateral_mps2, _LATERAL_MPS2):
        index, speed_mps = fast[at]
        name = f"lateral acceleration at {track.curves[index].position_m:.6g} m"
        yield Check(name, lateral_mps2[at], "m/s²", *_LATERAL_MPS2, f"curves[{index}]",
                    f"{mps_to_kmh(speed_mps):.4g} km/h in a radius of {radii_m[index]:.4g} m")  # fmt: skip


def _limit_at(track: Track, position_m: float) -> float:
    """Speed limit at a position, m/s."""
    after = bisect_right(track.speed_limits, position_m, key=lambda row: row.position_m)
    return track.speed_limits[after - 1].speed_mps


def _tunnels(track: Track) -> Iterator[Figure]:
    for index in _telling([row.cross_section_m2 for row in track.tunnels], _TUNNEL_M2):
        row = track.tunnels[index]
        yield Check(f"tunnel cross section at {row.position_m:.6g} m", row.cross_section_m2, "m²", *_TUNNEL_M2,
                    f"tunnels[{index}]", "diameter or area?")  # fmt: skip


def value_range(values: list[float]) -> str:
    """Least and largest value, as text."""
    low, high = f"{min(values):.6g}", f"{max(values):.6g}"
    return low if low == high else f"{low} to {high}"


def _net_height_m(track: Track) -> float:
    ends_m = [*(row.position_m for row in track.gradients[1:]), track.length_m]
    return sum(
        (end_m - row.position_m) * row.gradient_permil / KILO
        for row, end_m in zip(track.gradients, ends_m, strict=True)
    )
