"""A picture of a best-first search: the tree it grew, and what it took from the queue."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from tgvdp.report import palette, style

if TYPE_CHECKING:
    from tgvdp.methods.grid.trace import Trace

#: Looks of what was pruned, by reason: colour and mark.
PRUNED = {"delay": (palette.PURPLE, "v"), "bound": (palette.ORANGE, "s"), "dominance": (palette.SKY, "o")}


def plot_trace(trace: "Trace") -> style.Picture:
    """Draw the tree of a search over distance and speed: labels made, expanded, pruned and why, and the paths found.

    Returns
    -------
    matplotlib.figure.Figure
    """
    grid = trace.grid
    distance, speed = style.distance_scale(float(grid.station_m[-1])), style.speed_scale(float(grid.level_mps[-1]))
    x = grid.station_m[grid.graph.layer] * distance.factor
    y = grid.level_mps[grid.level] * speed.factor
    figure = style.new_figure(bottom_in=1.1)
    axes = figure.add_subplot()
    axes.plot(x, y, ".", color=palette.FAINT, markersize=4.0, zorder=1)
    expanded = {step.label for step in trace.steps if step.became == "expanded"}
    on_paths = {label for found in trace.found for label in trace.path(found)}
    for labels, color, width, order in (
        ([label for label in range(1, len(trace.node)) if int(trace.parent[label]) >= 0], palette.FAINT, 0.8, 2),
        ([label for label in expanded if trace.parent[label] >= 0], palette.MUTED, 1.1, 3),
        ([label for label in on_paths if trace.parent[label] >= 0], palette.BLUE, 2.2, 5),
    ):
        ends = trace.node[labels] if labels else np.empty(0, dtype=np.int32)
        starts = trace.node[trace.parent[labels]] if labels else ends
        pieces = np.stack((np.column_stack((x[starts], y[starts])), np.column_stack((x[ends], y[ends]))), axis=1)
        axes.add_collection(LineCollection(list(pieces), colors=color, linewidths=width, zorder=order))
    pruned = [(node, reason) for step in trace.steps for node, reason in step.pruned]
    for shift, (reason, (color, mark)) in enumerate(PRUNED.items()):
        nodes = sorted({node for node, why in pruned if why == reason})
        beside = 0.006 * (shift - 1) * float(x[-1])
        axes.plot(x[nodes] + beside, y[nodes], mark, color=color, markersize=4.5, linestyle="none", zorder=4)
    style.dress(axes, f"Distance ({distance.unit})", f"Speed ({speed.unit})")
    counted = trace.counters
    style.title(
        axes, "What does the search look at?",
        f"{counted['expanded']} labels expanded of {counted['labels']}, {counted['generated']} children generated, "
        f"{len(trace.found)} paths; effective branching factor {trace.branching:.2f} at depth {trace.depth}",
    )  # fmt: skip
    handles = [
        Line2D([], [], color=palette.FAINT, label="label made"),
        Line2D([], [], color=palette.MUTED, label="expanded"),
        Line2D([], [], color=palette.BLUE, linewidth=2.2, label="path found"),
        *(
            Line2D([], [], color=color, marker=mark, linestyle="none", label=f"pruned by {reason}")
            for reason, (color, mark) in PRUNED.items()
        ),
    ]
    style.legend(figure, "lower center", handles, 3)
    return figure
