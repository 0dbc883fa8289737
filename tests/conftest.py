"""Fixtures that all tests share."""

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests.helpers.settings import SHARED

# How long a case takes says something of the machine alone, and of what else it does.
settings.register_profile("untimed", settings.default, deadline=None)
settings.load_profile("untimed")


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
