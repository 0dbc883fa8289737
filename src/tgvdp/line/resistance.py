"""What the line adds to a train's resistance at each point of the track: gradients, curves, tunnels.

A train of some length meets the mean of these over its length (mass strip), or their value at its head (point).
"""

from collections.abc import Sequence

import numpy as np

from tgvdp.errors import InputError
from tgvdp.line.piecewise import Floats, Piecewise, as_table
from tgvdp.memory import ask_for
from tgvdp.model.track import Curve, Track
from tgvdp.model.train import TunnelDrag

#: From this radius on Röckl's formula is 650/(R − 55), below it 500/(R − 30), ‰ of the weight; it jumps there.
ROECKL_RADIUS_M = 300.0
_ROECKL_POLE_M = 30.0
#: Linear pieces for Röckl's formula along a transition: 0.002 % of it off at most.
_ROECKL_PIECES = 64
#: Memory that each of them takes until the line is resolved, B.
_PIECE_B = 250.0


def gradient_permil(track: Track) -> Piecewise:
    """Gradient along the track, ‰."""
    return _held(track.gradients, track.length_m)


def _held(rows: Sequence[tuple[float, float]], length_m: float) -> Piecewise:
    """Build a function from values that hold until the next row; none means 0."""
    table = as_table(rows or [(0.0, 0.0)])
    knot_m, value = np.append(table[:, 0], length_m), table[:, 1]
    return Piecewise.of(knot_m, value, value, value)


def curve_permil(track: Track, formula: str) -> Piecewise:
    """Curve resistance along the track, ‰ of the weight.

    Parameters
    ----------
    track : Track
        Curvature, 1/radius, is linear along each of its curves; the sign of a radius only tells the side.
    formula : {"none", "800/R", "roeckl"}
        As in `tgvdp.model.convention.Convention`.

    Raises
    ------
    InputError
        When a radius is too small for the formula.
    """
    if formula == "none" or not track.curves:
        return _held([], track.length_m)
    if formula == "roeckl":
        transitions = sum(row.radius_start_m != row.radius_end_m for row in track.curves)
        ask_for(_PIECE_B * _ROECKL_PIECES * transitions, f"Röckl's formula along {transitions:,} transitions")
    ends_m = [*(row.position_m for row in track.curves[1:]), track.length_m]
    pieces = [
        _one_curve(track, index, row, end_m, formula)
        for index, (row, end_m) in enumerate(zip(track.curves, ends_m, strict=True))
    ]
    starts_m, left, middle, right = np.concatenate(pieces, axis=1)
    return Piecewise.of(np.append(starts_m, track.length_m), left, middle, right)


def _one_curve(track: Track, index: int, row: Curve, end_m: float, formula: str) -> Floats:
    """Pieces of one curve: rows of start, and of the resistance at their left end, middle and right end."""
    if formula == "roeckl" and min(abs(row.radius_start_m), abs(row.radius_end_m)) <= _ROECKL_POLE_M:
        raise InputError(
            f"track {track.name}: curves[{index}].radius must be above {_ROECKL_POLE_M:g} m for Röckl's formula, "
            f"got {min(row[1:], key=abs):g} m"
        )
    first, last = 1.0 / row.radius_start_m, 1.0 / row.radius_end_m
    shares = {0.0, 1.0}
    if first != last:
        at = [0.0] if formula == "800/R" else [0.0, 1.0 / ROECKL_RADIUS_M, -1.0 / ROECKL_RADIUS_M]
        shares |= {share for value in at if 0.0 < (share := (value - first) / (last - first)) < 1.0}
    cuts = np.array(sorted(shares))
    if formula == "roeckl" and first != last:
        parts = np.arange(_ROECKL_PIECES) / _ROECKL_PIECES
        cuts = np.append((cuts[:-1, None] + np.diff(cuts)[:, None] * parts).ravel(), 1.0)
    curvature = np.abs(first + (last - first) * cuts)
    middle = 0.5 * (curvature[:-1] + curvature[1:])
    below = middle > 1.0 / ROECKL_RADIUS_M  # of one formula each, also where it jumps

    def resistance(at: Floats) -> Floats:
        if formula == "800/R":
            return 800.0 * at
        return np.where(below, 500.0 * at / (1.0 - 30.0 * at), 650.0 * at / (1.0 - 55.0 * at))

    left, right = resistance(curvature[:-1]), resistance(curvature[1:])
    starts_m = row.position_m + (end_m - row.position_m) * cuts[:-1]
    return np.array([starts_m, left, 0.5 * (left + right), right])


def tunnel_drag(train_name: str, drags: Sequence[TunnelDrag], track: Track) -> Piecewise:
    """Additional coefficient of v² along the track, N/(m/s)².

    Raises
    ------
    InputError
        When the train has no coefficient for the cross section of a tunnel: there is no rule for others.
    """
    known = {row.cross_section_m2: row.davis_c_n_per_mps2 for row in drags}
    rows = [(0.0, 0.0)]
    for index, tunnel in enumerate(track.tunnels):
        if tunnel.cross_section_m2 not in known:
            names = ", ".join(f"{area_m2:g}" for area_m2 in known) or "none"
            raise InputError(
                f"train {train_name}: tunnel_drag is not known for {tunnel.cross_section_m2:g} m², the cross section "
                f"of tunnels[{index}] of track {track.name}; known cross sections in m²: {names}"
            )
        start_m = max(tunnel.position_m, rows[-1][0])  # the end of the one before it, but for rounding
        end_m = min(tunnel.position_m + tunnel.length_m, track.length_m)
        if end_m > start_m:
            if start_m == rows[-1][0]:
                rows.pop()
            rows += [(start_m, known[tunnel.cross_section_m2]), (end_m, 0.0)]
    if rows[-1][0] == track.length_m:
        rows.pop()
    return _held(rows, track.length_m)
