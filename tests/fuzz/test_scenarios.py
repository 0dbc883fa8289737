"""Whole scenarios, made up: each is refused by name, or searched, replayed and proved without a word of numpy."""

import math
import warnings

import tomli_w
from hypothesis import event, example, given
from hypothesis import strategies as st

from fuzz.inputs import leaves, with_value
from tests.helpers.settings import fuzz
from tgvdp.errors import BudgetExceededError, InfeasibleError, InputError
from tgvdp.formats import load_scenario
from tgvdp.options.search import SearchOptions, arguments_of

#: One figure of half of the scenarios is far from usual.
FAR = (1e-6, 1e-3, 1e3, 1e6)


@st.composite
def rows(draw, length_m, name, values, least):
    at = draw(st.lists(st.floats(0.0, max(length_m, 1e-9), exclude_max=True), min_size=0, max_size=4, unique=True))
    starts = sorted({0.0, *at}) if least or at else []
    return [{"from_m": start, name: draw(values)} for start in starts]


TRAINS = st.fixed_dictionaries(
    {
        "mass_t": st.floats(20.0, 2000.0),
        "davis_a_n": st.floats(0.0, 2e4),
        "davis_b_n_per_kmh": st.floats(0.0, 300.0),
        "davis_c_n_per_kmh2": st.floats(0.0, 3.0),
        "max_speed_kmh": st.floats(40.0, 350.0),
        "friction_brake_kn": st.floats(100.0, 500.0),
        "traction": st.fixed_dictionaries({"force_kn": st.floats(20.0, 500.0), "power_kw": st.floats(300.0, 9000.0)}),
    },
    optional={
        "length_m": st.floats(20.0, 700.0),
        "rotating_mass_factor": st.floats(1.0, 1.2),
        "braking": st.fixed_dictionaries({"force_kn": st.floats(10.0, 300.0), "power_kw": st.floats(300.0, 9000.0)}),
        "traction_efficiency_pct": st.floats(50.0, 100.0),
        "regeneration_efficiency_pct": st.floats(0.0, 90.0),
        "auxiliary_power_kw": st.floats(0.0, 500.0),
        "max_acceleration_mps2": st.floats(0.2, 1.5),
        "max_deceleration_mps2": st.floats(0.2, 1.5),
    },
)
RUNS = st.fixed_dictionaries(
    {"points": st.integers(2, 5), "max_margin_pct": st.floats(1.0, 60.0), "time_limit_s": st.just(1.0)},
    optional={
        "energy": st.sampled_from(["wheel", "pantograph", "map"]),
        "convention": st.sampled_from(["ttobench", "osrd", "trainruns"]),
        "mass_model": st.sampled_from(["point", "strip"]),
        "reverse": st.booleans(),
        "start_speed_kmh": st.floats(0.0, 20.0),
        "end_speed_kmh": st.floats(0.0, 20.0),
        "wind_kmh": st.floats(-20.0, 60.0),
        "clean": st.booleans(),
    },
)


@st.composite
def scenarios(draw):
    length_m = draw(st.floats(300.0, 3e4))
    track = {
        "length_m": length_m,
        "speed_limits": draw(rows(length_m, "speed_kmh", st.floats(20.0, 300.0), least=True)),
        "gradients": draw(rows(length_m, "gradient_permil", st.floats(-15.0, 15.0), least=False)),
    }
    if draw(st.booleans()):
        at_m = draw(st.floats(0.0, length_m))
        track["neutral_sections"] = [{"from_m": at_m, "length_m": draw(st.floats(1.0, 500.0))}]
    scenario = {"train": draw(TRAINS), "track": track, "run": draw(RUNS)}
    if draw(st.booleans()):
        numbers = [place for place, value in leaves(scenario) if isinstance(value, float)]
        place, factor = draw(st.sampled_from(numbers)), draw(st.sampled_from(FAR))
        scenario = with_value(scenario, place, lambda table, last: table.__setitem__(last, factor * table[last]))
    return scenario


#: On the mesh of the refinement its fastest run is slower than the second point.
TARDY = {
    "train": {
        "mass_t": 20.0, "davis_a_n": 0.0, "davis_b_n_per_kmh": 1.0, "davis_c_n_per_kmh2": 0.0, "max_speed_kmh": 40.0,
        "friction_brake_kn": 100.0, "traction": {"force_kn": 20.0, "power_kw": 300.0},
    },
    "track": {"length_m": 300.0, "speed_limits": [{"from_m": 0.0, "speed_kmh": 20.0}]},
    "run": {"points": 2, "max_margin_pct": 1.0, "time_limit_s": 1.0, "energy": "map", "start_speed_kmh": 8.9e-31},
}  # fmt: skip


@fuzz(25)
@given(scenarios())
@example(TARDY)
def test_any_scenario_is_refused_by_name_or_answered(tmp_path_factory, scenario):
    from tgvdp.api.run import run_search

    path = tmp_path_factory.mktemp("scenario") / "trip.toml"
    path.write_text(tomli_w.dumps(scenario))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            read = load_scenario(path)
            result = run_search(read.train, read.track, SearchOptions(**arguments_of(read.options)))
            verdicts, certificate = result.verify(0.5), result.certify(0.5)
        except (InputError, InfeasibleError, BudgetExceededError) as error:
            assert "\n" not in str(error)
            assert len(str(error)) > 10
            event(type(error).__name__)
            return
    event("answered")
    assert len(verdicts) == len(result.front) >= 1
    assert all(math.isfinite(value) for value in (*result.front.time_s, *result.front.energy_j))
    known = certificate.lower_bound_j == certificate.lower_bound_j
    below_j = certificate.lower_bound_j[known] - result.front.energy_j[known]
    scale_j = max(
        abs(result.fastest.energy_j), 0.5 * read.train.inertia_kg * result.fastest.profile.speed_mps.max() ** 2
    )
    assert below_j.max(initial=-math.inf) <= 1e-6 * scale_j
