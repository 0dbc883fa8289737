"""Effort curves: caps, points, polynomials, and where they would be negative."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tgvdp.errors import InputError
from tgvdp.formats import load_train
from tgvdp.model.effort import EffortCurve, EffortPiece


def seed_traction_n(speed_kmh):
    """F+ of the seed text 'binary and demand formulations', N; the later piece at a jump."""
    if speed_kmh < 50:
        return -354.1 * speed_kmh + 2.44e5
    if speed_kmh < 60:
        return -881.3 * speed_kmh + 2.704e5
    return -0.05265 * speed_kmh**3 + 28.78 * speed_kmh**2 - 5603 * speed_kmh + 4.566e5


def seed_braking_n(speed_kmh):
    """F- of the same text, N."""
    if speed_kmh < 20:
        return 9925 * speed_kmh + 1.243
    if speed_kmh < 100:
        return 1.985e5
    return 5.389 * speed_kmh**2 - 2583 * speed_kmh + 4.012e5


@given(st.floats(0.0, 220.0))
def test_alstom_curves_are_the_seeds_formulas(speed_kmh):
    if min(abs(speed_kmh - jump) for jump in (20, 50, 60, 100)) < 1e-9:
        return  # on which side of a jump a rounded speed falls is nobody's concern
    emu = load_train("alstom-emu")
    assert emu.traction.effort_n(speed_kmh / 3.6) == pytest.approx(seed_traction_n(speed_kmh), rel=1e-9)
    assert emu.braking.effort_n(speed_kmh / 3.6) == pytest.approx(seed_braking_n(speed_kmh), rel=1e-9)


def test_alstom_curves_jump_where_the_formulations_page_says():
    emu = load_train("alstom-emu")

    def jump_n(curve, speed_kmh):
        return curve.effort_n(speed_kmh / 3.6 + 1e-9) - curve.effort_n(speed_kmh / 3.6 - 1e-9)

    assert jump_n(emu.traction, 50) == pytest.approx(40, abs=0.5)
    assert jump_n(emu.traction, 60) == pytest.approx(-4866, abs=0.5)
    assert jump_n(emu.braking, 100) == pytest.approx(-1710, abs=0.5)
    assert emu.braking.effort_n(0.0) == pytest.approx(1.243)


def test_the_table_has_one_row_a_piece_for_the_kernels():
    emu = load_train("alstom-emu")
    assert emu.traction.table.shape == (3, 6)
    assert emu.traction.table.dtype == np.float64
    assert not emu.traction.table.flags.writeable
    assert emu.traction.table[:, 0] == pytest.approx([0.0, 50 / 3.6, 60 / 3.6])
    for row in emu.traction.table:
        v = row[0] + 1.0
        value = row[1] / v + row[2] + row[3] * v + row[4] * v**2 + row[5] * v**3
        assert emu.traction.effort_n(v) == pytest.approx(value, rel=1e-12)


def test_caps_meet_at_the_corner_speed():
    curve = EffortCurve.from_caps(200e3, 4e6)
    assert curve.effort_n(0.0) == curve.effort_n(19.99) == 200e3
    assert curve.effort_n(20.0) == pytest.approx(200e3)
    assert curve.effort_n(40.0) == pytest.approx(100e3)
    assert EffortCurve.from_caps(0.0).effort_n(10.0) == 0.0
    assert EffortCurve.from_caps(5.0).effort_n(1e6) == 5.0


def test_points_are_linear_between_and_constant_after_and_may_jump():
    curve = EffortCurve.from_points([(0, 100), (10, 100), (10, 80), (20, 0)])
    assert [curve.effort_n(v) for v in (0, 9.999, 10, 15, 20, 99)] == pytest.approx([100, 100, 80, 40, 0, 0])
    assert EffortCurve.from_points([(0, 7)]).effort_n(3.0) == 7.0


@given(st.lists(st.tuples(st.floats(1e-3, 1e3), st.floats(0.0, 1e6)), max_size=8), st.floats(0.0, 1e6))
def test_points_never_give_negative_effort(rows, start_n):
    speeds = np.cumsum([0.0, *(step for step, _ in rows)])
    curve = EffortCurve.from_points(zip(speeds, [start_n, *(effort for _, effort in rows)], strict=True))
    for speed, effort in zip(speeds, [start_n, *(effort for _, effort in rows)], strict=True):
        assert curve.effort_n(speed) == pytest.approx(effort, rel=1e-6, abs=1e-3)


def test_coefficients_of_wildly_different_size_are_harmless():
    curve = EffortCurve(((0.0, 0.0, 1e5, -1.0, 0.0, 1e-320), (10.0, 1e6, 0.0, 0.0, 5e-324)))
    assert curve.effort_n(5.0) == 1e5 - 5.0


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: EffortCurve(()), "the first piece must start at 0 m/s"),
        (lambda: EffortCurve((EffortPiece(1.0, c0_n=5.0),)), "the first piece must start at 0 m/s"),
        (lambda: EffortCurve(((0.0, 0.0, 5.0), (2.0, 0.0, 4.0), (2.0, 0.0, 3.0))), "speeds must increase"),
        (lambda: EffortCurve(((0.0, 1e6),)), "infinite at standstill"),
        (lambda: EffortCurve(((0.0, 0.0, math.nan),)), "must be finite"),
        (lambda: EffortCurve(((),)), "pieces"),
        (lambda: EffortCurve(((0.0, 0.0, -1.0),)), "must be at least 0 N, got -1 N at 0 m/s"),
        # 100 - 60 v + 8 v² is 100 N at 0 and 300 N at 10 m/s, and negative around its minimum between them
        (lambda: EffortCurve(((0.0, 0.0, 100.0, -60.0, 8.0), (10.0, 0.0, 300.0))), "got -12.5 N at 3.75 m/s"),
        (lambda: EffortCurve.from_caps(-1.0), "force must be at least 0 N"),
        (lambda: EffortCurve.from_caps(1.0, 0.0), "power must be above 0 W"),
        (lambda: EffortCurve.from_caps(1.0, -5.0), "power must be at least 0 W"),
        (lambda: EffortCurve.from_caps(math.inf), "force must be finite"),
        (lambda: EffortCurve.from_points([]), "the first point must be at 0 m/s"),
        (lambda: EffortCurve.from_points([(1.0, 5.0)]), "the first point must be at 0 m/s"),
        (lambda: EffortCurve.from_points([(0, 5), (3, 4), (2, 3)]), r"points\[2\].speed must not decrease"),
        (lambda: EffortCurve.from_points([(0, 5), (3, 4), (3, 3), (3, 2)]), r"points\[3\].speed is given a third time"),
        (lambda: EffortCurve.from_points([(0, 5), (3, -4)]), r"points\[1\].effort must be at least 0 N, got -4 N"),
        (lambda: EffortCurve.from_points([(0, "5")]), r"points\[0\].effort must be a number"),
        (lambda: EffortCurve.from_points([(0, 5, 6)]), r"points\[0\] must be"),
    ],
)
def test_bad_curves_are_refused(build, message):
    with pytest.raises(InputError, match=message):
        build()
