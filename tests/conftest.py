"""Fixtures that all tests share."""

from pathlib import Path

import pytest

SHARED = Path(__file__).resolve().parents[2] / "shared"


@pytest.fixture(scope="session")
def shared() -> Path:
    """Folder of real input data by others, beside the project; absent on most machines."""
    if not SHARED.is_dir():
        pytest.skip("the folder of reference data beside the project is absent")
    return SHARED
