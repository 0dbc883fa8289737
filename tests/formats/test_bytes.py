"""Files from elsewhere: their bytes are read, and no file that they name is."""

import pytest

from tgvdp.errors import InputError
from tgvdp.formats import load_bytes, load_track, load_train
from tgvdp.model import catalog


def test_bytes_hold_what_the_file_holds():
    data = catalog.path("tgv", "train").read_bytes()
    (scenario,) = load_bytes("mine.toml", data)
    assert scenario.train == load_train("tgv")


def test_names_of_the_catalog_are_followed():
    (scenario,) = load_bytes("mine.toml", b'train = "tgv"\ntrack = "flat-100km"\n')
    assert (scenario.train, scenario.track) == (load_train("tgv"), load_track("flat-100km"))


@pytest.mark.parametrize("reference", ["secret.toml", "./secret.toml", "../secret.toml", "/etc/passwd"])
def test_a_file_that_is_named_is_not_opened(reference, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "secret.toml").write_bytes(catalog.path("tgv", "train").read_bytes())
    with pytest.raises(InputError, match=r"mine.toml: train: references another file, which is not at hand"):
        load_bytes("mine.toml", f'train = "{reference}"\n'.encode())


def test_a_table_of_effort_that_is_named_is_not_opened(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "effort.csv").write_text("speed_kmh,effort_kn\n0,200\n100,100\n")
    text = (
        "[train]\nmass_t = 100\nmax_speed_kmh = 100\nfriction_brake_kn = 50\n"
        "davis_a_n = 1\ndavis_b_n_per_kmh = 0\ndavis_c_n_per_kmh2 = 0\n"
        'traction = {file = "effort.csv"}\n'
    )
    with pytest.raises(InputError, match=r"train.traction.file: references another file"):
        load_bytes("mine.toml", text.encode())


def test_an_error_names_the_file():
    with pytest.raises(InputError, match=r"^broken.json: is not valid JSON"):
        load_bytes("broken.json", b"{")
