"""Whatever a slip of the pen does to a SFERA message, it loads or is refused in one line that names the place."""

import pytest
from hypothesis import given

from tests.helpers.settings import fuzz
from tests.helpers.sfera_case import TRAIN, message
from tests.helpers.xml_slips import loads_or_is_refused, mutated

pytest.importorskip("lxml")

#: Refusals of a whole file have no line; all others do.
WHOLE_FILE = ("holds ", "is nested too deeply", "is empty")


@pytest.mark.parametrize("text", [message(), TRAIN.strip()], ids=["journey", "train"])
def test_mutated_messages_load_or_are_refused_in_one_line(tmp_path, text):
    path = tmp_path / "input.xml"

    @fuzz()
    @given(mutated(text))
    def check(changed):
        loads_or_is_refused(path, changed.encode(), WHOLE_FILE)

    check()
