"""Which lines the picture of success draws."""

from tgvdp.report.trial_plots import plot_success
from tgvdp.trials.panels import family_panels


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


def test_lines_have_colours_of_their_own():
    figure = plot_success(family_panels([row(solver, solved) for solver, solved in SOLVERS.items()]), "detail")
    colours = [line.get_color() for line in figure.axes[0].get_lines()]
    assert len(colours) == len(set(colours)) == 6
