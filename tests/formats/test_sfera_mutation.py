"""Whatever a slip of the pen does to a SFERA message, it loads or is refused in one line that names the place."""

import re

import pytest
from hypothesis import given

from tests.helpers.settings import fuzz
from tests.helpers.sfera_case import TRAIN, message
from tests.helpers.xml_slips import mutated
from tgvdp.errors import InputError
from tgvdp.formats import describe_file

pytest.importorskip("lxml")

#: Refusals of a whole file have no line; all others do.
WHOLE_FILE = ("holds ", "is nested too deeply", "is empty")


@pytest.mark.parametrize("text", [message(), TRAIN.strip()], ids=["journey", "train"])
def test_mutated_messages_load_or_are_refused_in_one_line(tmp_path, text):
    path = tmp_path / "input.xml"

    @fuzz()
    @given(mutated(text))
    def check(changed):
        path.write_text(changed, encoding="utf-8")
        try:
            description = describe_file(path)
        except InputError as error:
            line = str(error)
            assert line.startswith(f"{path}: ")
            assert line.isprintable()
            assert len(line) < 800 + len(str(path))
            rest = line.removeprefix(f"{path}: ")
            assert re.match(r"line \d+[,:] ", rest) or rest.startswith(WHOLE_FILE), rest
        else:
            assert str(description)

    check()
