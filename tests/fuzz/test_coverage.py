"""The harness of atheris, where that is installed: what it takes for a crash, and what not."""

import pytest

pytest.importorskip("atheris", reason="extra fuzz")

from fuzz import coverage
from tgvdp.errors import InputError


@pytest.mark.parametrize("data", [b"", b"\0{", b"\2\xff", b"\1length = 1e400", b"\3<a", b"\5PK\3\4"])
def test_what_is_refused_is_no_crash(data):
    coverage.read(data)


def test_other_errors_and_several_lines_are(monkeypatch):
    def fails(error):
        def load(*_):
            raise error

        monkeypatch.setattr(coverage, "load_bytes", load)

    fails(InputError("one\ntwo"))
    with pytest.raises(AssertionError, match="not one line"):
        coverage.read(b"\0{}")
    fails(IndexError("out of range"))
    with pytest.raises(IndexError):
        coverage.read(b"\0{}")
