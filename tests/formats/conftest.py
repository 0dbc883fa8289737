"""Fixtures of tests that read files."""

import pytest


@pytest.fixture
def saved(tmp_path):
    """Writes a text or bytes into a file and returns its path."""

    def save(content, name="line.csv"):
        data = content if isinstance(content, bytes) else content.encode("utf-8")
        (tmp_path / name).write_bytes(data)
        return tmp_path / name

    return save


@pytest.fixture
def saved_xml(tmp_path):
    """Writes a text and returns the name of something in it."""

    def save(text, part=""):
        (tmp_path / "file.xml").write_text(text, encoding="utf-8")
        return f"{tmp_path / 'file.xml'}{part}"

    return save


@pytest.fixture
def sfera(shared):
    """Folder of the published schema of SFERA and of real messages."""
    folder = shared / "sfera"
    if not folder.is_dir():
        pytest.skip("the schema and messages of SFERA are absent")
    return folder
