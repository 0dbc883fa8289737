"""Recorded runs as runs of the model: a run of the model that is written down comes back."""

import numpy as np
import pytest

import tgvdp
from tgvdp.errors import InputError
from tgvdp.runs.profile import REGIMES, profile_of
from tgvdp.runs.recorded import placed, recorded_profile, sections_of


def at_times(profile, t):
    """Position and speed of a run at some times: the acceleration is constant within a row."""
    row = np.searchsorted(profile.time_s, t, side="right").clip(1, profile.time_s.size - 1) - 1
    v = np.interp(t, profile.time_s, profile.speed_mps)
    return profile.position_m[row] + 0.5 * (profile.speed_mps[row] + v) * (t - profile.time_s[row]), v


def every_second(result, index):
    """A run of the model, and its position, speed and time every second."""
    profile = result.profile(index)
    t = np.append(np.arange(0.0, profile.duration_s, 1.0), profile.duration_s)
    return result.trip, profile, *at_times(profile, t), t


@pytest.fixture(scope="module")
def driven():
    return every_second(tgvdp.search("alstom-emu", "lgv-100km", destination_m=20_000.0, points=5), 2)


@pytest.mark.parametrize("given", ["xv", "vt", "xt", "xvt"])
def test_a_run_of_the_model_comes_back(driven, given):
    trip, profile, x, v, t = driven
    columns = {"x": x, "v": v, "t": t}
    # Mean speeds over 10 s, which records of positions get, would blur the switches.
    (motion,) = sections_of(*(columns[key] if key in given else None for key in "xvt"), window_s=0.0)
    if "x" not in given:
        motion = placed(motion, 0.0, 20_000.0)
    back = recorded_profile(trip, motion)
    assert back.duration_s == pytest.approx(profile.duration_s, rel=2e-3)
    assert back.total_energy_j == pytest.approx(profile.total_energy_j, rel=0.01)
    assert back.balance.pantograph_j == pytest.approx(profile.balance.pantograph_j, rel=0.01)


def test_coasting_is_no_braking_by_a_hair():
    """A record every second blurs the efforts: those within the noise are none.

    The front knows partial effort at a speed that drifts as such; a record knows it by its acceleration, as traction.
    """
    trip, profile, x, v, t = every_second(tgvdp.search("tgv", "lgv-100km", points=6), 4)
    (motion,) = sections_of(x, v, t, window_s=0.0)
    by_acceleration = profile_of(trip, profile.position_m - trip.origin_m, profile.speed_mps**2)
    shares = [
        np.bincount(one.regime[:-1], np.diff(one.position_m), 4) / trip.distance_m
        for one in (by_acceleration, recorded_profile(trip, motion))
    ]
    assert shares[0][REGIMES.index("coasting")] > 0.4
    assert shares[1] == pytest.approx(shares[0], abs=0.05)


def test_the_mean_speed_takes_noise_away(driven):
    trip, profile, x, v, t = driven
    noise = np.random.default_rng(7).normal(0.0, 0.15, v.size)
    noisy = np.where((v > 1.0), v + noise, v)
    (raw,) = sections_of(x, noisy, t)
    (mean,) = sections_of(x, noisy, t, window_s=10.0)
    raw_j, mean_j = (recorded_profile(trip, motion).total_energy_j for motion in (raw, mean))
    assert raw_j > 1.2 * profile.total_energy_j
    assert mean_j == pytest.approx(profile.total_energy_j, rel=0.03)


def test_a_constant_speed_is_its_own_mean():
    t = np.arange(0.0, 101.0)
    (motion,) = sections_of(20.0 * t, None, t)
    assert motion.speed_mps == pytest.approx(20.0)


@pytest.mark.parametrize("every_s", [1.0, 5.0, 10.0])
def test_positions_tell_that_a_run_starts_and_stops(driven, every_s):
    """Means of intervals have no standstill: a record every 10 s began at 2.4 m/s by them."""
    _, profile, *_ = driven
    t = np.append(np.arange(0.0, profile.duration_s, every_s), profile.duration_s)
    (motion,) = sections_of(at_times(profile, t)[0], None, t)
    assert (motion.speed_mps[0], motion.speed_mps[-1]) == (0.0, 0.0)
    assert motion.time_s[-1] - motion.time_s[0] == pytest.approx(profile.duration_s)
    assert motion.doubt_mps < 0.5


@pytest.mark.parametrize("every_s", [1.0, 5.0, 10.0])
def test_positions_tell_the_speeds_between_which_a_record_is_cut(driven, every_s):
    _, profile, *_ = driven
    t = np.arange(0.1 * profile.duration_s, 0.8 * profile.duration_s, every_s)
    x, v = at_times(profile, t)
    (motion,) = sections_of(x, None, t)
    assert motion.speed_mps[[0, -1]] == pytest.approx(v[[0, -1]], abs=max(0.5, motion.doubt_mps))
    assert (motion.position_m == x).all()


def test_a_change_of_acceleration_at_an_end_is_told_as_a_doubt():
    t = np.arange(0.0, 200.0, 10.0)
    v = np.interp(t, [0.0, 175.0, 190.0], [40.0, 40.0, 20.0])
    x = np.concatenate(([0.0], np.cumsum([400.0] * 17 + [350.0, 250.0])))
    (motion,) = sections_of(x, None, t)
    assert 0.5 < motion.doubt_mps
    assert motion.speed_mps[-1] == pytest.approx(v[-1], abs=motion.doubt_mps)


def test_noise_of_positions_is_no_speed_at_the_start(driven):
    _, _, x, _, t = driven
    noisy = x + np.random.default_rng(3).normal(0.0, 0.1, x.size)
    (motion,) = sections_of(noisy, None, t)
    assert (motion.speed_mps[0], motion.speed_mps[-1]) == (0.0, 0.0)


def test_a_record_cut_at_speed_is_not_taken_for_a_start_however_noisy(driven):
    """Noise of 1 m leaves speeds in doubt by some m/s, but from a stand no train comes that far in two seconds."""
    _, profile, *_ = driven
    t = np.arange(0.1 * profile.duration_s, 0.6 * profile.duration_s, 1.0)
    x, _ = at_times(profile, t)
    for seed in range(20):
        (motion,) = sections_of(x + np.random.default_rng(seed).normal(0.0, 1.0, x.size), None, t)
        assert min(motion.speed_mps[0], motion.speed_mps[-1]) > 10.0


def test_a_train_departs_and_arrives_between_rows_of_positions(driven):
    """The record has stands before and behind, and neither departure nor arrival is one of its rows."""
    _, profile, *_ = driven
    t = np.arange(-34.0, profile.duration_s + 40.0, 10.0)
    x, _ = at_times(profile, np.clip(t, 0.0, profile.duration_s))
    (motion,) = sections_of(x, None, t)
    assert (motion.speed_mps[0], motion.speed_mps[-1]) == (0.0, 0.0)
    assert (motion.position_m[0], motion.position_m[-1]) == (0.0, 20_000.0)
    assert motion.time_s[[0, -1]] == pytest.approx([0.0, profile.duration_s], abs=1.0)


@pytest.mark.parametrize("given", ["xvt", "vt"])
@pytest.mark.parametrize("every_s", [1.0, 2.0, 5.0])
def test_a_train_departs_and_arrives_between_rows_of_speeds(driven, given, every_s):
    """Stands between two rows counted as running time: up to two intervals, which the optimum used."""
    trip, profile, *_ = driven
    t = np.arange(-0.6 * every_s - 30.0, profile.duration_s + 40.0, every_s)
    x, v = at_times(profile, np.clip(t, 0.0, profile.duration_s))
    v[(t < 0.0) | (t > profile.duration_s)] = 0.0
    columns = {"x": x, "v": v, "t": t}
    (motion,) = sections_of(*(columns[key] if key in given else None for key in "xvt"))
    assert motion.time_s[[0, -1]] == pytest.approx([0.0, profile.duration_s], abs=0.2 * every_s)
    assert motion.position_m[-1] - motion.position_m[0] == pytest.approx(20_000.0, rel=1e-3)
    back = recorded_profile(trip, placed(motion, 0.0, 20_000.0))
    assert back.duration_s == pytest.approx(motion.time_s[-1] - motion.time_s[0], rel=2e-3)
    assert back.total_energy_j == pytest.approx(profile.total_energy_j, rel=0.01)


@pytest.mark.parametrize("every_s", [1.0, 10.0])
def test_means_cost_no_energy_on_slopes(every_s):
    """Where gradients begin is known: rounded with the speeds they were driven up and braked down (1.9 to 3.5 %)."""
    result = tgvdp.search("tgv", "lgv-100km", at_margin=(0.05,))
    profile = result.profile(len(result.front) - 1)
    t = np.append(np.arange(0.0, profile.duration_s, every_s), profile.duration_s)
    x, v = at_times(profile, t)
    for speeds in (None, v):
        (motion,) = sections_of(x, speeds, t, window_s=10.0)
        back = recorded_profile(result.trip, motion)
        assert back.total_energy_j == pytest.approx(profile.total_energy_j, rel=1e-3)


def test_sections_lie_between_stands():
    t = np.arange(0.0, 200.0)
    v = np.select([(t > 10) & (t < 60), (t > 90) & (t < 150)], [10.0, 15.0], 0.0)
    first, second = sections_of(None, v, t)
    assert (first.time_s[0], first.time_s[-1]) == (10.0, 60.0)
    assert (second.time_s[0], second.time_s[-1]) == (90.0, 150.0)
    for one in (first, second):
        assert (one.speed_mps[0], one.speed_mps[-1]) == (0.0, 0.0)
    moved = placed(second, 100.0, 500.0)
    assert (moved.position_m[0], moved.position_m[-1]) == (100.0, 500.0)


@pytest.mark.parametrize(
    ("x", "v", "t", "message"),
    [
        (None, [0.0, -1.0, 0.0], [0.0, 1.0, 2.0], "speed must not be negative"),
        (None, [5.0, 5.0, 5.0], [0.0, 2.0, 1.0], "time goes back after 2 s"),
        ([0.0, 500.0, 400.0], None, [0.0, 20.0, 40.0], "position goes back after 500 m"),
        (None, [0.0, 0.1, 0.0], [0.0, 1.0, 2.0], "never moves"),
        ([0.0, 50.0, 100.0], [0.0, 0.0, 5.0], None, "speed is 0 at both ends"),
        ([0.0, 50.0, 100.0], None, [7.0, 7.0, 7.0], "all rows have the same time"),
    ],
)
def test_records_that_are_no_run(x, v, t, message):
    columns = [None if values is None else np.array(values) for values in (x, v, t)]
    with pytest.raises(InputError, match=message):
        sections_of(*columns)


def test_a_section_ends_after_its_start():
    (motion,) = sections_of(None, np.full(50, 10.0), np.arange(50.0))
    with pytest.raises(InputError, match="must end after its start, got 5 m after 10 m"):
        placed(motion, 10.0, 5.0)
