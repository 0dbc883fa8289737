"""Read again what tgvdp has written: objects of a schema."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tgvdp.errors import InputError


def read_object(path: Path) -> dict[str, Any]:
    """Read the object that a file of JSON holds.

    Raises
    ------
    InputError
        When it cannot be read, or holds none.
    """
    try:
        content = json.loads(path.read_bytes())
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise InputError(f"{path}: is not valid JSON: {error}") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: must hold an object")
    return content


def require_schema(path: Path, content: Mapping[str, Any], schema: str) -> None:
    """Raise `InputError` where an object is not of a schema, but of another version, or of another kind."""
    given = content.get("schema")
    if given != schema:
        raise InputError(f"{path}: must be a result of this tgvdp, schema {schema}, got {given!r:.40}")
