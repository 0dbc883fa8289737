"""Pictures of trials: nothing is cut off, steps are whole numbers, and what the legend names is seen."""

import itertools

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from tgvdp.report.trial_plots import FamilyPanel, Series, SizePanel, median_series, plot_sizes, plot_success


def series(name, steps, values, **more):
    return Series(name, np.array(steps, dtype=float), np.array(values, dtype=float), **more)


def success_of(steps):
    many = len(steps)
    drawn = series("sa:unary", steps, np.geomspace(0.676, 0.02, many))
    times = [series("dp", steps, np.full(many, 4e-4)), series("sa:unary", steps, np.full(many, 1.2e-2))]
    return plot_success([FamilyPanel(name, [drawn], times) for name in ("easy", "zones")], "detail")


def sizes_of(steps):
    lines = {
        "Bits": [series("unary", steps, [16.0] * len(steps))],
        "Couplers": [series("unary", steps, [120.0] * len(steps))],
    }
    return plot_sizes([SizePanel(name, lines) for name in ("easy", "zones")], "detail")


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
        if axes.get_subplotspec().is_first_col():  # the others share its labels
            assert len(shown(axes.yaxis)) >= 2
    numbers = shown(figure.axes[-1].xaxis)
    assert numbers and all(text.isdigit() for text in numbers)
    if len(steps) == 1:
        assert numbers == ["8"]


@pytest.mark.parametrize("name", ["dp", "sa:unary:penalty=0.4:beta=5..40:reads=100:sweeps=100:some=more", "s" * 90])
def test_legends_and_numbers_of_steps_fit_four_families(name):
    lines = [series(one + name, [4, 20, 100, 150, 200], [0.1, 0.2, 0.3, 0.4, 0.5]) for one in "abcdef"]
    figure = plot_success(
        [FamilyPanel(family, lines, lines) for family in ("easy", "demand", "zones", "tight")], "detail"
    )
    FigureCanvasAgg(figure).draw()
    (legend,) = figure.legends
    box = legend.get_window_extent()
    assert 0.0 <= box.x0 < box.x1 <= figure.bbox.x1 and box.y0 >= 0.0
    for axes in figure.axes[4:]:
        low, high = axes.get_xlim()
        seen = [label for label in axes.get_xticklabels() if low <= label.get_position()[0] <= high]
        boxes = [label.get_window_extent() for label in seen]
        assert all(one.x1 < other.x0 for one, other in itertools.pairwise(boxes))


@pytest.mark.parametrize("steps", [[8], [4, 8, 60]])
def test_what_the_legend_names_is_seen(steps):
    for axes in success_of(steps).axes:
        low, high = axes.get_ylim()
        for line in axes.get_lines():
            values = np.asarray(line.get_ydata(), dtype=float)
            drawn = line.get_marker() not in ("None", None) or values.size > 1
            assert not values.size or (drawn and np.any((values >= low) & (values <= high))), line.get_label()


def test_medians_leave_out_what_has_no_value():
    rows = [{"N": 4, "p": 0.2}, {"N": 4, "p": 0.4}, {"N": 6, "p": 0.0}, {"N": 8, "p": None}]
    found = median_series("sa", rows, "N", "p")
    assert found.x.tolist() == [4.0, 6.0] and found.y.tolist() == pytest.approx([0.3, 0.0])
    assert median_series("sa", rows[3:], "N", "p") is None


def test_what_is_infinite_is_not_drawn():
    figure = plot_success([FamilyPanel("easy", [], [series("sa", [4, 6], [1.0, np.inf])])], "detail")
    assert [line.get_xdata().tolist() for line in figure.axes[1].get_lines()] == [[4.0]]
