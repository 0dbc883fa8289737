"""Pictures of trials: nothing is cut off, steps are whole numbers, and what the legend names is seen."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from tgvdp.report.trial_plots import Series, median_series, plot_sizes, plot_success


def series(name, steps, values, **more):
    return Series(name, np.array(steps, dtype=float), np.array(values, dtype=float), **more)


def success_of(steps):
    many = len(steps)
    drawn = series("sa:unary", steps, np.geomspace(0.676, 0.02, many))
    tosses = series("coin tosses, unary (exact)", steps, np.geomspace(7.6e-5, 1e-20, many), dashed=True)
    times = [series("dp", steps, np.full(many, 4e-4)), series("milp", steps, np.full(many, 1.2e-2))]
    return plot_success([drawn, tosses], times, "detail")


def sizes_of(steps):
    bits = [series("variables, unary", steps, [16.0] * len(steps))]
    return plot_sizes(bits, [series("variables, unary", steps, [120.0] * len(steps))], "detail")


def shown(axis):
    low, high = sorted(axis.get_view_interval())
    return [
        label.get_text() for place, label in zip(axis.get_ticklocs(), axis.get_ticklabels(), strict=True)
        if low <= place <= high
    ]  # fmt: skip


@pytest.mark.parametrize("steps", [[8], [8, 9], [4, 8, 60]])
@pytest.mark.parametrize("picture", [success_of, sizes_of])
def test_labels_are_whole_and_within_the_picture(picture, steps):
    figure = picture(steps)
    FigureCanvasAgg(figure).draw()
    for axes in figure.axes:
        for label in (axes.xaxis.label, axes.yaxis.label, *axes.get_yticklabels(which="both")):
            box = label.get_window_extent()
            assert 0.0 <= box.x0 < box.x1 <= figure.bbox.x1 or not label.get_text(), label.get_text()
        assert len(shown(axes.yaxis)) >= 2
    numbers = shown(figure.axes[-1].xaxis)
    assert numbers and all(text.isdigit() for text in numbers)
    if len(steps) == 1:
        assert numbers == ["8"]


@pytest.mark.parametrize("steps", [[8], [4, 8, 60]])
def test_what_the_legend_names_is_seen(steps):
    for axes in success_of(steps).axes:
        low, high = axes.get_ylim()
        for line in axes.get_lines():
            values = np.asarray(line.get_ydata(), dtype=float)
            drawn = line.get_marker() not in ("None", None) or values.size > 1
            assert not values.size or (drawn and np.any((values >= low) & (values <= high))), line.get_label()


def test_medians_replace_what_never_succeeded_by_its_bound():
    rows = [{"N": 4, "p": 0.2, "low": 0.1, "high": 0.3}, {"N": 4, "p": 0.4, "low": 0.3, "high": 0.5},
            {"N": 6, "p": 0.0, "low": 0.0, "high": 0.02}, {"N": 8, "p": None, "low": None, "high": None}]  # fmt: skip
    found = median_series("sa", rows, "N", "p", "low", "high")
    assert found.x.tolist() == [4.0, 6.0]
    assert found.y.tolist() == pytest.approx([0.3, 0.02])
    assert found.only_bound.tolist() == [False, True]
    assert median_series("sa", rows[3:], "N", "p") is None
