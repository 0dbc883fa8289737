"""Results travel between processes: a copy is drawn, replayed and certified by the kernels of the original."""

import pickle

import numpy as np
import pytest

import tgvdp
from tests.helpers.journey_case import LINE, METRO
from tgvdp._jit.watch import watch
from tgvdp.model.journey import Journey, TimingPoint


def test_copy_of_a_result_is_as_good_as_the_result():
    result = tgvdp.search("alstom-emu", "flat-100km", destination_m=3e3, points=4)
    verdicts, certificate = result.verify(), result.certify()
    with watch() as compiled:
        copy = pickle.loads(pickle.dumps(result))
        assert copy.verify() == verdicts
        assert np.array_equal(copy.certify().gap_pct, certificate.gap_pct)
    assert compiled == []  # the same types: nothing of a copy can be written
    assert not copy.fastest.profile.speed_mps.flags.writeable
    assert np.array_equal(copy.profile(2).time_s, result.profile(2).time_s)
    assert copy.fastest.profile.balance == result.fastest.profile.balance


STOPS = [TimingPoint(at_m, lowest_mps=0.0, highest_mps=0.0) for at_m in (0.0, 6000.0)]
TIMETABLE = Journey(name="metro", points=(STOPS[0], TimingPoint(2000.0, latest_s=200.0), STOPS[1]))


@pytest.mark.parametrize("timetable", [None, TIMETABLE], ids=["free", "with a window"])
def test_copy_of_a_journey_is_as_good_as_the_journey(timetable):
    journey = tgvdp.journey(METRO, LINE, timetable, points=3)
    copy = pickle.loads(pickle.dumps(journey))
    assert repr(copy) == repr(journey)
    assert np.array_equal(copy.front.energy_j, journey.front.energy_j)
    assert np.array_equal(copy.profile(1).time_s, journey.profile(1).time_s)
    assert copy.verify() == journey.verify()
    assert np.array_equal(copy.certify().lower_bound_j, journey.certify().lower_bound_j)
    if timetable is None:
        assert copy.margins("5%").energy_j == journey.margins("5%").energy_j
