"""Which steps compile kernels: the shortened ones of `tgvdp._jit.pipeline`, or numba's own.

The shortened ones are made of numba's inner parts, so they are used only with versions of numba that they were tested
with. All others compile by numba's own steps, which takes about four times as long and gives the same results.
``$TGVDP_PIPELINE`` = ``plain`` or ``short`` chooses by hand.
"""

import functools
import os

import numba

from tgvdp.errors import InputError

PIPELINE_VARIABLE = "TGVDP_PIPELINE"
#: Versions of numba, without their last number, at which tests/_jit/test_pipeline.py and the fingerprint test passed.
TESTED = ("0.62", "0.63", "0.64", "0.65", "0.66", "0.67", "0.68")
_CHOICES = {"": None, "short": True, "plain": False}


@functools.cache
def shortened() -> bool:
    """Whether kernels are compiled by the shortened steps."""
    choice = os.environ.get(PIPELINE_VARIABLE, "")
    if choice not in _CHOICES:
        raise InputError(f"{PIPELINE_VARIABLE}: must be 'short' or 'plain', got {choice!r:.60}")
    wanted = _CHOICES[choice]
    return numba.__version__.startswith(tuple(f"{version}." for version in TESTED)) if wanted is None else wanted
