"""Where data by others lie, and how hard the fuzzing tests try."""

import os
from pathlib import Path

from hypothesis import HealthCheck, settings

SHARED = Path(__file__).resolve().parents[3] / "shared"

#: How many mutated files each reader is given: a share of them here, the same ones every time; as many as the variable
#: says, and new ones every time, where it is set (2000 in a release check).
_EXAMPLES = os.environ.get("TGVDP_FUZZ_EXAMPLES")


def fuzz(examples: int = 300) -> settings:
    """Return the settings of a test that feeds mutated or made-up files, ``examples`` of them by default."""
    return settings(
        max_examples=int(_EXAMPLES or examples),
        derandomize=_EXAMPLES is None,
        database=None,
        deadline=None,
        suppress_health_check=list(HealthCheck),
    )
