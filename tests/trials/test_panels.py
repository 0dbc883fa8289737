"""Which lines the picture of success draws."""

import math

from tgvdp.report import palette
from tgvdp.report.trial_plots import plot_success
from tgvdp.trials.panels import family_panels, size_panels


def row(solver, solved, chance=0.5):
    times = {"TTS99 s": 1.0, "TTS99 s low": 0.5, "TTS99 s high": 2.0}
    return {"family": "easy", "N": 6, "solver": solver, "solved": solved, "p median": chance, **times}


SOLVERS = {
    "dp": 9,
    "milp": 8,
    "scip": 8,
    "greedy": 7,
    "random": 1,
    "sa:unary": 5,
    "sa:bits": 2,
    "pt:unary": 4,
    "tabu": 3,
}


def test_the_best_variants_of_six_solvers_are_drawn():
    (panel,) = family_panels([row(solver, solved) for solver, solved in SOLVERS.items()])
    assert [line.name for line in panel.success] == ["dp", "milp", "scip", "greedy", "sa:unary", "pt:unary"]
    assert [line.name for line in panel.tts_s] == [line.name for line in panel.success]


def test_a_solver_that_fails_at_a_size_is_drawn_there_with_no_success():
    """Its line ended before, as if it had not been asked."""
    never = {"N": 8, "TTS99 s": math.inf, "TTS99 s low": math.inf, "TTS99 s high": math.inf}
    (panel,) = panels = family_panels([row("random", 1), row("random", 0, 0.0) | never])
    assert panel.success[0].y.tolist() == [0.5, 0.0]
    success, times = (axes.get_lines()[0].get_xdata().tolist() for axes in plot_success(panels, "detail").axes)
    assert (success, times) == ([6.0, 8.0], [6.0])


def test_lines_have_colours_of_their_own():
    figure = plot_success(family_panels([row(solver, solved) for solver, solved in SOLVERS.items()]), "detail")
    colours = [line.get_color() for line in figure.axes[0].get_lines()]
    assert len(colours) == len(set(colours)) == 6


def test_solvers_without_a_colour_of_their_own_take_what_is_left():
    solvers = {"dp": 9, "milp": 8, "closed": 7, "random": 1}
    figure = plot_success(family_panels([row(solver, solved) for solver, solved in solvers.items()]), "detail")
    assert len({line.get_color() for line in figure.axes[0].get_lines()} | {palette.INK}) == 5


def test_families_are_not_joined_in_one_line_of_sizes():
    def size(problem, steps, bits):
        counts = {"# Decision Variables": bits, "# Non-Zero Coefficients": 3 * bits}
        return {"Problem": problem, "N": steps, "encoding": "unary", **counts}

    rows = [size("substation-k2-n006", 6, 43), size("substation-k2-n008", 8, 94), size("substation-k3-n008", 9, 89)]
    laid = [{"Problem": "substation-k2-n006", "N": 6, "encoding": "unary", "topology": "zephyr", "qubits": 90}]
    two, three = size_panels(rows, laid)
    assert (two.family, three.family) == ("substation-k2", "substation-k3")
    assert {name: [one.y.tolist() for one in lines] for name, lines in two.lines.items()} == {
        "Bits": [[43.0, 94.0]], "Couplers": [[86.0, 188.0]], "Qubits, zephyr": [[90.0]],
    }  # fmt: skip
    assert [one.y.tolist() for one in three.lines["Bits"]] == [[89.0]] and three.lines["Qubits, zephyr"] == []


def test_a_family_without_a_line_has_no_panel():
    rows = [row("sa:unary", 9), row("sa:bits", 2) | {"family": "zones"}]
    assert [panel.family for panel in family_panels(rows)] == ["easy"]
