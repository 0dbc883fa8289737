"""Fixtures that all tests share."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

SHARED = Path(__file__).resolve().parents[2] / "shared"

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


@pytest.fixture(scope="session")
def shared() -> Path:
    """Folder of real input data by others, beside the project; absent on most machines."""
    if not SHARED.is_dir():
        pytest.skip("the folder of reference data beside the project is absent")
    return SHARED


@pytest.fixture(scope="session", autouse=True)
def ctrl_c() -> Iterator[None]:
    """Hear Ctrl-C, as on a terminal: shells make what they start in the background deaf to it, and so its children."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
