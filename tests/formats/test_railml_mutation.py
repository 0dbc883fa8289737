"""Whatever a slip of the pen does to a railML file, it loads or is refused in one line that names the place."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.railml_case import SAMPLES
from tests.helpers.settings import fuzz
from tests.helpers.xml_slips import loads_or_is_refused, mutated

pytest.importorskip("lxml")

#: Refusals of a whole file, or of what is asked of it, have no line; all others do.
WHOLE_FILE = ("holds no track and no train", "is nested too deeply", "holds XML, but neither", "holds no ", "is not ")


@pytest.mark.parametrize("sample", SAMPLES)
def test_mutated_files_load_or_are_refused_in_one_line(tmp_path, sample):
    path = tmp_path / "input.xml"

    @fuzz()
    @given(mutated(SAMPLES[sample]))
    def check(text):
        loads_or_is_refused(path, text.encode(), WHOLE_FILE)

    check()


@pytest.mark.parametrize("sample", SAMPLES)
def test_mutated_bytes_load_or_are_refused_in_one_line(tmp_path, sample):
    path = tmp_path / "input.xml"
    original = SAMPLES[sample].encode()

    @fuzz()
    @given(st.integers(0, len(original)), st.integers(0, 20), st.binary(max_size=4))
    def check(at, length, instead):
        data = original[:at] + instead + original[at + length :]
        if data.lstrip()[:1] == b"<":  # or it is no XML, and other readers judge it
            loads_or_is_refused(path, data, WHOLE_FILE)

    check()
