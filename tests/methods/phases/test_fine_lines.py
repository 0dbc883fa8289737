"""Lines with a gradient every few metres: a speed that is held is one phase, and dabs of a brake before a limit go."""

import numpy as np
import pytest

import tgvdp
from tests.helpers.phases_case import phases_s, surveyed
from tests.helpers.trips import commuter, trip_on
from tgvdp.methods.costate.mesh import Mesh
from tgvdp.methods.phases.approach import approach
from tgvdp.methods.phases.held import join_holds
from tgvdp.methods.phases.plan import LASTS_S, PLAN_COLUMNS, REGIME, plan_of
from tgvdp.methods.phases.regimes import tell_regimes
from tgvdp.methods.phases.way import Room, Run, is_sound, way_of
from tgvdp.physics.cell import Rows
from tgvdp.physics.codes import BRAKING, COASTING, HOLDING, TRACTION
from tgvdp.runs.fastest import fastest_run


@pytest.mark.parametrize("seed", range(3))
def test_runs_on_surveyed_lines_have_few_phases(seed):
    """They had 62 to 193 phases next to the fastest run, of which 37 to 49 lasted less than a second."""
    result = tgvdp.search(commuter(), surveyed(seed), points=12, max_margin=0.06)
    lasts_s = [phases_s(result.profile(i))[:-1] for i in range(1, len(result.front))]
    assert max(len(phases) for phases in lasts_s) <= 45
    assert np.mean([(phases < 1.0).sum() for phases in lasts_s]) <= 4.0
    assert all(verdict.ok for verdict in result.verify())
    unpruned = tgvdp.search(commuter(), surveyed(seed), points=12, max_margin=0.06, min_phase_s=0.0)
    assert (result.front.time_s <= result.fastest.time_s * np.linspace(1.0, 1.06, 12) * (1.0 + 1e-9)).all()
    assert (result.front.energy_j <= unpruned.front.energy_j * (1.0 + 5e-4)).all()


def phases(regimes, speeds, step_s=0.5):
    """Phases of a run of so many rows of the same duration: its room, rows, plan, and their number."""
    speed = np.array(speeds, dtype=float)
    x_m = np.concatenate(([0.0], np.cumsum(0.5 * step_s * (speed[1:] + speed[:-1]))))
    run = Run.of(np.zeros((5, len(speed))))
    run.x[:], run.w[:], run.time[:], run.regime[:-1] = x_m, speed**2, step_s, regimes
    plan, count = np.zeros((len(speed), PLAN_COLUMNS)), 0
    mesh = Mesh.of(trip_on([(0.0, 40.0)]), fastest_run(trip_on([(0.0, 40.0)])))
    way = way_of(mesh.train, mesh.cells, Rows(mesh.envelope.x_m, mesh.envelope.w), mesh.tables)
    count = plan_of(way, run, len(speed), plan)
    return run, len(speed), plan, count


T, H, C, B = TRACTION, HOLDING, COASTING, BRAKING
HELD = {
    "between two holds": ([H, C, H, B, H], [20.0, 20.0, 20.1, 20.1, 20.0, 20.0], [H] * 5),
    "beside a hold": ([T, C, H], [20.0, 20.6, 20.5, 20.5], [T, H, H]),
    "another speed": ([H, C, C, H], [20.0, 20.0, 19.8, 19.6, 19.6], [H, C, C, H]),
    "no hold beside it": ([T, C, T], [20.0, 20.1, 20.1, 20.2], [T, C, T]),
    "long enough": ([C] * 8 + [H] * 8, [20.2 - 0.02 * i for i in range(17)], [C] * 8 + [H] * 8),
}


@pytest.mark.parametrize("regimes, speeds, joined", HELD.values(), ids=HELD)
def test_what_keeps_the_speed_beside_a_hold_is_part_of_it(regimes, speeds, joined):
    run, n, plan, count = phases(regimes, speeds)
    assert join_holds(run, n, plan, count, 3.0) == (joined != regimes)
    assert run.regime[:-1].tolist() == joined


@pytest.fixture(scope="module")
def dabbing():
    """A run that coasts to a lower limit a little too fast: it brakes for less than half a second."""
    trip = trip_on([(0.0, 40.0), (5000.0, 30.0)])
    mesh = Mesh.of(trip, fastest_run(trip))
    way = way_of(mesh.train, mesh.cells, Rows(mesh.envelope.x_m, mesh.envelope.w), mesh.tables)
    result = tgvdp.search(
        trip.train, trip.track, at_s=tuple(fastest_run(trip).duration_s * np.linspace(1.001, 1.1, 40)), min_phase_s=0.0
    )
    for i in range(len(result.front)):
        profile = result.profile(i)
        run = Run.of(np.zeros((5, len(profile.position_m))))
        run.x[:], run.w[:] = profile.position_m, profile.speed_mps**2
        n, plan = len(run.x), np.zeros((100, PLAN_COLUMNS))
        tell_regimes(way, run, 0, 0, n - 1)
        count = plan_of(way, run, n, plan)
        for c in range(1, count - 1):
            before, now, after = plan[c - 1 : c + 2, REGIME]
            if before == COASTING and now == BRAKING and after == HOLDING and plan[c, LASTS_S] < 0.5:
                price = float(result._found.multiplier_j_per_s[result.front.source[i]])
                return way, run, n, plan, count, price
    raise AssertionError("no run brakes for less than half a second")


@pytest.mark.parametrize("most_j", [1e6, 0.0])
def test_a_train_coasts_a_little_earlier_in_place_of_a_dab_of_the_brake(dabbing, most_j):
    way, run, n, plan, count, price = dabbing
    out = Run.of(np.zeros((5, 2 * n + 20_000)))
    m, left = approach(way, run, n, plan, count, price, 0.5, Room(most_j, -np.inf, np.inf, 0.0, 0.0), out)
    if most_j == 0.0:  # that is not for nothing
        assert m == 0
        return
    assert is_sound(way, out, m, Rows(run.x, run.w), 0, n - 1)
    new = np.zeros((100, PLAN_COLUMNS))
    tell_regimes(way, out, 0, 0, m - 1)
    fewer = plan_of(way, out, m, new)
    assert fewer == count - 1
    assert not (new[: fewer - 1, LASTS_S] < 0.5).any()
    assert 0.0 < most_j - left.most_j < 3e-4 * run.energy[: n - 1].sum()
