"""Packages of the extra `quantum`: imported when first needed, and missed in one line."""

import importlib
from typing import Any

from tgvdp.errors import MissingExtraError

EXTRA = "quantum"


def extra(module: str, purpose: str) -> Any:
    """Import a module of an optional package.

    Parameters
    ----------
    module : str
        Such as ``dwave.samplers``.
    purpose : str
        What needs it, for the message.

    Raises
    ------
    MissingExtraError
        When it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        missing = error.name or module
        message = f"{purpose} needs the package {missing!r}, which is not installed: pip install 'tgvdp[{EXTRA}]'"
        raise MissingExtraError(message) from None
