"""What was drawn: the data of lines, bands and labels, not pixels."""

import sys
from dataclasses import replace

import matplotlib
import numpy as np
import pytest
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgba

from tests.helpers.report_case import Found, make_result, railway_trip, toy_trip
from tgvdp import search
from tgvdp.errors import InputError
from tgvdp.model.energy import PANTOGRAPH, WHEEL, EnergyMap, EnergyModel
from tgvdp.report import palette, plot_effort, plot_front, plot_price, plot_profile, plot_speed_time, style
from tgvdp.report.gallery import draw
from tgvdp.report.line_met import altitude_of, features_of, speed_limits_of
from tgvdp.report.pictures import PICTURES, pictures_of
from tgvdp.report.profile_plots import speed_curve
from tgvdp.runs.profile import profile_of

MAP = EnergyModel(
    "map",
    EnergyMap(speed_mps=(0.0, 50.0), demand=(-1.0, 0.0, 1.0), power_w=((0.0,) * 3, (0.0, 0.0, 2e7)), name="made up"),
)


@pytest.fixture(scope="module")
def result():
    return make_result(railway_trip(), [24.0, 20.0, 18.0, 16.0])


@pytest.fixture(scope="module")
def toy():
    return make_result(toy_trip(), [0.6, 0.5])


def line_named(axes, label):
    return next(line for line in axes.lines if line.get_label() == label)


def collections(axes, kind):
    return [item for item in axes.collections if isinstance(item, kind)]


def legend_of(figure):
    return figure.axes[0].get_legend().get_texts()


def texts(axes):
    return [text.get_text() for text in axes.texts]


def test_front_draws_delay_on_x_and_saving_on_y(result):
    axes = plot_front(result).axes[0]
    line = line_named(axes, "Pareto front")
    np.testing.assert_allclose(line.get_xdata(), result.front.time_s - result.fastest.time_s)
    np.testing.assert_allclose(line.get_ydata(), 100 * (1 - result.front.energy_j / result.fastest.energy_j))
    fastest = line_named(axes, "fastest run")
    assert (list(fastest.get_xdata()), list(fastest.get_ydata())) == ([0.0], [0.0])
    assert axes.get_xlabel().startswith("Delay (s)")
    assert axes.get_ylabel() == "Energy saved (%)"
    assert axes.get_title(loc="left").endswith("?")
    assert "Test train on Test line, 4 km; top left is better" in texts(axes)


def test_names_are_not_read_as_mathematics(result):
    odd = replace(result.trip, track=replace(result.trip.track, name=r"$\nonsense$ {50 %}"))
    figure = plot_front(replace(result, trip=odd))
    figure.draw_without_rendering()
    assert r"Test train on $\nonsense$ {50 %}, 4 km; top left is better" in texts(figure.axes[0])


def test_front_labels_round_margins_where_they_are(result):
    axes = plot_front(result).axes[0]
    margins = 100 * (result.front.time_s / result.fastest.time_s - 1)
    labels = [text for text in axes.texts if "% saved" in text.get_text()]
    assert 1 <= len(labels) <= 6
    for label in labels:
        margin = float(label.get_text().split(" %")[0])
        assert margin == round(margin)
        delay, saved = label.xy
        assert delay == pytest.approx(margin / 100 * result.fastest.time_s)
        assert saved == pytest.approx(np.interp(margin, margins, line_named(axes, "Pareto front").get_ydata()))


def test_no_margin_is_labelled_before_the_first_point(result):
    late = replace(result, fastest=replace(result.fastest, time_s=0.8 * result.fastest.time_s))
    labels = [text.xy[0] for text in plot_front(late).axes[0].texts if "% saved" in text.get_text()]
    assert min(labels) >= result.front.time_s[0] - late.fastest.time_s


def test_right_axis_shows_the_energy(result):
    figure = plot_front(result)
    figure.draw_without_rendering()
    (right,) = figure.axes[0].child_axes
    assert right.get_ylabel() == "Energy at the wheel (kWh)"
    low, high = figure.axes[0].get_ylim()
    whole = result.fastest.energy_j / 3.6e6
    assert sorted(right.get_ylim()) == pytest.approx([whole * (1 - high / 100), whole * (1 - low / 100)])


def test_band_of_the_lower_bound_lies_above_the_front(result):
    bound_j = 0.98 * result.front.energy_j
    (band,) = collections(plot_front(result, bound_j).axes[0], PolyCollection)
    top = band.get_paths()[0].vertices[:, 1].max()
    assert top == pytest.approx(100 * (1 - bound_j[-1] / result.fastest.energy_j))
    assert not collections(plot_front(result).axes[0], PolyCollection)
    most_kwh = 0.02 * result.front.energy_j.max() / 3.6e6
    assert f"room up to the proven bound, at most {most_kwh:.3g} kWh" in [
        text.get_text() for text in legend_of(plot_front(result, bound_j))
    ]
    nothing_known = np.full(4, -np.inf)
    unbound = plot_front(result, nothing_known)
    assert not collections(unbound.axes[0], PolyCollection)
    assert not any("bound" in text.get_text() for text in legend_of(unbound))
    with pytest.raises(InputError, match="4 values, got 1"):
        plot_front(result, [1.0])


def test_delays_of_ten_minutes_are_drawn_in_minutes():
    result = make_result(railway_trip(), [24.0, 4.0])
    axes = plot_front(result).axes[0]
    assert axes.get_xlabel().startswith("Delay (min)")
    delay = line_named(axes, "Pareto front").get_xdata()
    np.testing.assert_allclose(delay, (result.front.time_s - result.fastest.time_s) / 60)


def test_single_point_and_free_run_still_have_axes():
    result = make_result(railway_trip(), [24.0])
    low, high = plot_front(result).axes[0].get_xlim()
    assert low < 0.0 < high
    plot_effort(result).draw_without_rendering()


def test_profile_draws_fastest_middle_and_thriftiest(result):
    figure = plot_profile(result)
    axes = figure.axes[0]
    runs = collections(axes, LineCollection)
    drawn = [np.concatenate(run.get_segments())[:, 1].max() for run in runs]
    assert drawn == pytest.approx([24.0 * 3.6, 18.0 * 3.6, 16.0 * 3.6])
    for run in runs:
        x = np.concatenate(run.get_segments())[:, 0]
        assert (x[0], x[-1]) == pytest.approx((1.0, 5.0))
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[0].startswith("fastest, ")
    assert len(labels) == 3
    assert all("% time" in label and "−" in label for label in labels[1:])


def test_regimes_are_in_colour_and_named(result):
    figure = plot_profile(result)
    profile = result.fastest.profile
    fastest = collections(figure.axes[0], LineCollection)[0]
    changes = np.flatnonzero(np.diff(profile.regime)) + 1
    expected = [palette.REGIME_COLORS[profile.regime_names[row]] for row in (0, *changes)]
    assert [tuple(color) for color in fastest.get_colors()] == [to_rgba(color) for color in expected]
    starts = [segment[0, 0] for segment in fastest.get_segments()]
    np.testing.assert_allclose(starts, profile.position_m[[0, *changes]] / 1e3)
    shown = {text.get_text() for text in figure.axes[0].get_legend().get_texts()}
    assert {"traction", "braking", "speed limit"} <= shown


def test_speed_limits_are_those_of_line_and_train(result):
    position_m, limit_mps = speed_limits_of(result.trip)
    np.testing.assert_allclose(position_m, [1000.0, 2000.0, 4500.0, 5000.0])
    np.testing.assert_allclose(limit_mps, [30.0, 40.0, 25.0, 25.0])
    line = line_named(plot_profile(result).axes[0], "speed limit")
    np.testing.assert_allclose(line.get_xdata(), position_m / 1e3)
    np.testing.assert_allclose(line.get_ydata(), limit_mps * 3.6)
    assert line.get_drawstyle() == "steps-post"


def test_terrain_is_drawn_below_with_shared_x(result):
    position_m, altitude_m = altitude_of(result.trip)
    np.testing.assert_allclose(position_m, [1000.0, 2000.0, 3000.0, 5000.0])
    np.testing.assert_allclose(altitude_m, [500.0, 500.0, 510.0, 500.0])
    upper, lower = plot_profile(result).axes
    assert upper.get_shared_x_axes().joined(upper, lower)
    assert lower.get_ylabel() == "Altitude (m)"
    assert lower.get_xlabel() == "Position on the line (km)"
    np.testing.assert_allclose(lower.lines[0].get_ydata(), altitude_m)


def test_toy_is_drawn_in_metres_without_terrain(toy):
    assert altitude_of(toy.trip) is None
    (axes,) = plot_profile(toy).axes
    assert axes.get_xlabel() == "Position on the line (m)"
    assert axes.get_ylabel() == "Speed (m/s)"
    assert axes.get_xlim() == (0.0, 2.0)
    # Its limit of 10 m/s would flatten the curves.
    assert axes.get_ylim()[1] < 1.0
    assert "speed limit" not in [text.get_text() for text in axes.get_legend().get_texts()]
    figure = plot_front(toy)
    assert figure.axes[0].child_axes[0].get_ylabel() == "Energy at the wheel (J)"


def test_speed_curve_is_smooth_and_follows_v_squared(toy):
    profile = toy.fastest.profile
    position_m, speed_mps, row = speed_curve(profile)
    assert np.abs(np.diff(speed_mps)).max() < 0.1 * speed_mps.max()
    np.testing.assert_allclose(
        speed_mps**2, np.interp(position_m, profile.position_m, profile.speed_mps**2), atol=1e-12
    )
    assert np.all(np.diff(position_m) > 0)
    assert np.all(profile.position_m[row] <= position_m)


def test_paths_beside_the_front_are_drawn_for_methods_on_a_grid(result):
    time_s = np.append(result.front.time_s, result.fastest.time_s + 30.0)
    energy_j = np.append(result.front.energy_j, 1.1 * result.fastest.energy_j)
    found = replace(result, method="exact", _found=Found(time_s, energy_j, result._found.rows))
    others = line_named(plot_front(found).axes[0], "other paths found")
    np.testing.assert_allclose(others.get_xydata(), [(30.0, -10.0)])


@pytest.mark.parametrize(
    ("energy", "name"),
    [(WHEEL, "Energy at the wheel"), (PANTOGRAPH, "Energy at the pantograph"), (MAP, "Energy by made up")],
)
def test_the_energy_axis_names_the_energy(result, energy, name):
    figure = plot_front(replace(result, trip=replace(result.trip, energy=energy)))
    assert figure.axes[0].child_axes[0].get_ylabel() == f"{name} (kWh)"


def test_price_shows_what_a_minute_saves():
    train, track = railway_trip().train, railway_trip().track
    found = search(train, track, energy="pantograph", points=12)
    axes = plot_price(found, 0.25).axes[0]
    (line,) = axes.lines
    np.testing.assert_allclose(line.get_xdata(), 100 * (found.front.time_s / found.fastest.time_s - 1))
    np.testing.assert_allclose(line.get_ydata()[1:], found.price_kwh_per_min[1:])
    (right,) = axes.child_axes
    assert right.get_ylabel() == "Money saved per minute (€/min)"
    assert pictures_of(found) == list(PICTURES)
    # At the wheel nobody is charged.
    assert not plot_price(search(train, track, points=3), 0.25).axes[0].child_axes


def test_price_needs_prices(result):
    assert "price" not in pictures_of(result)
    with pytest.raises(InputError, match="knows no prices"):
        plot_price(result)
    with pytest.raises(InputError, match="no picture 'pie'"):
        draw(result, "pie")


def test_speed_over_time_ends_with_each_run(result):
    axes = plot_speed_time(result).axes[0]
    ends = [np.concatenate(run.get_segments())[-1] for run in collections(axes, LineCollection)]
    expected = [result.fastest.time_s, result.front.time_s[2], result.front.time_s[-1]]
    np.testing.assert_allclose([end[0] for end in ends], expected)
    np.testing.assert_allclose([end[1] for end in ends], 0.0)


def test_effort_and_power_are_those_of_the_rows(result):
    upper, lower, terrain = plot_effort(result).axes
    assert (upper.get_ylabel(), lower.get_ylabel()) == ("Effort (kN)", "Power (MW)")
    assert terrain.get_xlabel() == "Position on the line (km)"
    profile = result.fastest.profile
    for axes, values in (
        (upper, profile.force_n[:-1] / 1e3),
        (lower, profile.force_n[:-1] * np.diff(profile.position_m) / np.diff(profile.time_s) / 1e6),
    ):
        drawn = np.concatenate(collections(axes, LineCollection)[0].get_segments())[:, 1]
        assert (drawn.min(), drawn.max()) == pytest.approx((values.min(), values.max()))


def test_pulses_are_drawn_as_their_means():
    trip = railway_trip()
    x = np.linspace(0.0, trip.distance_m, 801)
    u = x / trip.distance_m
    saw = 30.0 * (np.arange(x.size) % 4 > 1)  # 200 pulses
    w = 400.0 * np.minimum(1.0, 5.0 * np.minimum(u, 1.0 - u)) + saw * (u > 0.2) * (u < 0.8)
    base = make_result(trip, [20.0])
    pulsed = profile_of(trip, x, w)
    fastest = replace(base.fastest, profile=pulsed, time_s=pulsed.duration_s, energy_j=pulsed.total_energy_j)
    figure = plot_effort(replace(base, fastest=fastest))
    segments = collections(figure.axes[0], LineCollection)[0].get_segments()
    drawn = np.concatenate(segments)
    assert len(drawn) < 400
    assert "pulses are shown as their means" in str(texts(figure.axes[0]))
    # The same work, whatever is drawn: trapezoids of steps.
    order = np.concatenate([segment if index == 0 else segment[1:] for index, segment in enumerate(segments)])
    work_kj = np.sum(0.5 * (order[1:, 1] + order[:-1, 1]) * np.diff(order[:, 0]) * 1000.0)
    net_j = np.sum(pulsed.force_n[:-1] * np.diff(pulsed.position_m))
    assert work_kj * 1000.0 == pytest.approx(net_j, rel=1e-6, abs=1e-3 * pulsed.total_energy_j)


def test_the_line_beside_the_run_is_drawn():
    plain = railway_trip()
    rich = replace(
        plain.track,
        stops_m=(0.0, 1000.0, 3000.0, 6000.0),
        neutral_sections=((500.0, 100.0, False), (1500.0, 200.0, False), (4900.0, 400.0, True)),
        tunnels=((2500.0, 300.0, 60.0),),
        curves=((0.0, float("inf"), float("inf")), (1800.0, 700.0, 700.0), (2200.0, float("inf"), float("inf"))),
    )
    trip = replace(plain, track=rich)
    spans = {one.name: list(zip(one.from_m.tolist(), one.length_m.tolist(), strict=True)) for one in features_of(trip)}
    assert spans == {
        "stops": [(3000.0, 0.0)],
        "neutral": [(1500.0, 200.0)],  # what lies before the origin or behind the destination is cut off
        "lowered": [(4900.0, 100.0)],
        "tunnels": [(2500.0, 300.0)],
        "curves": [(1800.0, 400.0)],
    }
    axes = plot_profile(make_result(trip, [24.0, 20.0])).axes
    assert [label.get_text() for label in axes[1].get_yticklabels()] == list(spans)
    assert features_of(plain) == []


def test_notebooks_can_show_a_figure(result):
    assert plot_front(result)._repr_png_().startswith(b"\x89PNG")


def test_pictures_leave_global_settings_alone(result, monkeypatch):
    monkeypatch.delitem(sys.modules, "matplotlib.pyplot", raising=False)
    before = matplotlib.rcParams.copy()
    for plot in (plot_front, plot_profile, plot_speed_time, plot_effort):
        plot(result).draw_without_rendering()
    assert matplotlib.rcParams.copy() == before
    assert "matplotlib.pyplot" not in sys.modules


@pytest.mark.parametrize(
    ("seconds", "text"), [(1.23456, "1.235 s"), (59.9, "59.9 s"), (245.4, "4:05 min"), (3723.0, "1:02:03 h")]
)
def test_clock(seconds, text):
    assert style.clock(seconds) == text


@pytest.mark.parametrize("regimes", [tuple(palette.REGIME_COLORS)])
def test_every_regime_has_its_own_colour(regimes):
    from tgvdp.runs.profile import REGIMES

    assert regimes == REGIMES
    assert len(set(palette.REGIME_COLORS.values())) == len(REGIMES)
