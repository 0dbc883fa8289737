"""Results travel between processes: a copy is drawn, replayed and certified by the kernels of the original."""

import pickle

import numpy as np

import tgvdp
from tgvdp._jit.watch import watch


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
