"""What reading a file is refused with."""

from pathlib import Path

import pytest

from tgvdp.errors import InputError


def refusal(read, name, **options):
    """What a reader says against a file, or a part ``#name`` of one: one line, behind the name of the file."""
    with pytest.raises(InputError) as caught:
        read(name, **options)
    assert str(caught.value).isprintable()
    file = Path(str(name).partition("#")[0]).name
    return str(caught.value).partition(f"{file}: ")[2]
