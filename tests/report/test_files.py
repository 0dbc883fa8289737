"""The results folder: what is in it, whole or not at all, and where each file comes from."""

import hashlib
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import matplotlib.image
import pytest

from tests.helpers.report_case import PROVENANCE, VERDICT, make_result, railway_trip, toy_trip
from tgvdp.cli.screen import energy_table, power_and_cost
from tgvdp.errors import InputError
from tgvdp.report import check_writable, make_provenance, results, write_results
from tgvdp.report.files import check_new, write_files
from tgvdp.report.gallery import draw, front_files
from tgvdp.report.pictures import PICTURE_FORMATS, encode, pictures_of
from tgvdp.report.profiles import choose_runs

NAMES = {
    "result.json",
    "front.csv",
    "advice.csv",
    "profiles.csv",
    "front.png",
    "profile.png",
    "speed_time.png",
    "effort.png",
    "provenance.json",
}


@pytest.fixture(scope="module")
def result():
    return make_result(railway_trip(), [24.0, 20.0, 16.0])


@pytest.fixture(scope="module")
def folder(result, tmp_path_factory):
    home = tmp_path_factory.mktemp("results") / "new" / "folder"
    write_results(result, home, PROVENANCE, [VERDICT] * 3)
    return home


def test_folder_holds_the_files_and_nothing_else(folder):
    assert {path.name for path in folder.iterdir()} == NAMES


def test_result_json_is_one_object_with_provenance(folder):
    content = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    assert content["schema"] == "tgvdp.search/1"
    assert content["provenance"] == PROVENANCE


def test_every_file_is_tied_to_its_provenance_by_hash(folder):
    ledger = json.loads((folder / "provenance.json").read_text(encoding="utf-8"))
    assert ledger["options"] == PROVENANCE["options"]
    assert set(ledger["files"]) == NAMES - {"provenance.json"}
    for name, digest in ledger["files"].items():
        assert hashlib.sha256((folder / name).read_bytes()).hexdigest() == digest


@pytest.mark.parametrize("name", sorted(name for name in NAMES if name.endswith(".png")))
def test_pictures_are_readable_and_carry_provenance(folder, name):
    from PIL import Image

    with Image.open(folder / name) as picture:
        assert json.loads(picture.text["Comment"]) == PROVENANCE
    assert matplotlib.image.imread(folder / name).shape[1] > 1000


@pytest.mark.parametrize("format", PICTURE_FORMATS)
def test_pictures_in_every_format_with_letters_in_them(result, tmp_path, format):
    write_results(result, tmp_path, PROVENANCE, [VERDICT] * 3, pictures=[format])
    assert {path.suffix for path in tmp_path.iterdir()} == {".json", ".csv", f".{format}"}
    data = (tmp_path / f"profile.{format}").read_bytes()
    assert data.startswith({"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[format])
    if format == "svg":  # outlines: no font is needed to show it
        assert b"<text" not in data
        assert b"tgvdp 0.1.0" in data
    if format == "pdf":  # TrueType, embedded
        assert b"/FontFile2" in data
        assert b"/Type3" not in data


def test_pictures_are_the_same_files_again(result):
    first, second = (encode(draw(result, "front"), PROVENANCE, "svg") for _ in range(2))
    assert first == second


def test_no_pictures(result, tmp_path):
    write_results(result, tmp_path, PROVENANCE, [VERDICT] * 3, pictures=[])
    assert {path.name for path in tmp_path.iterdir()} == {name for name in NAMES if not name.endswith(".png")}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"pictures": ["gif"]}, "no format 'gif'"),
        ({"profiles": "ods"}, "profiles must be one of csv"),
        ({"profiles": "railtoolkit", "every_m": 100.0}, "driving course"),
        ({"every_m": 0.0}, "every_m must be above 0 m"),
        ({"every_m": 1e-6}, "rows of one run"),
    ],
)
def test_options_out_of_range(result, tmp_path, options, message):
    with pytest.raises(InputError, match=message):
        write_results(result, tmp_path / "out", PROVENANCE, [VERDICT] * 3, **options)
    assert list(tmp_path.iterdir()) == []


def test_provenance_is_that_of_the_result_unless_given(result, tmp_path):
    written = write_results(result, tmp_path, {}, [VERDICT] * 3, pictures=[])
    assert written.content["provenance"]["options"] == {"points": 3, "time_limit_s": 60.0, "max_memory_b": None}
    assert set(written.content["provenance"]["inputs"]) == {"train", "track"}
    assert json.loads((tmp_path / "result.json").read_text(encoding="utf-8")) == written.content
    assert {path.name for path in written.files} == {path.name for path in tmp_path.iterdir()}


def test_many_profiles_are_thinned_with_a_word(result, monkeypatch, tmp_path):
    told = []
    assert choose_runs(result, most_rows=90).points == [0, 2]
    assert choose_runs(result, most_rows=90).every_m is None
    assert choose_runs(result).points == [0, 1, 2]
    monkeypatch.setattr(results, "most_rows_in", lambda _: 90)
    content = write_results(result, tmp_path, PROVENANCE, [VERDICT] * 3, pictures=["png"], progress=told.append).content
    assert content["warning"] == "2 of 3 profiles are written, evenly spread: all would have 123 rows"
    lines = (tmp_path / "profiles.csv").read_text().splitlines()[1:]
    assert list(dict.fromkeys(line.split(",")[0] for line in lines)) == ["fastest", "0", "2"]
    assert told[0] == "summing up, 0 of 3"
    assert {"writing profiles, 0 of 2", "drawing"} <= set(told)


def test_runs_of_too_many_rows_are_sampled_with_a_word(result, tmp_path):
    chosen = choose_runs(result, most_rows=1)
    assert chosen.points == [0, 2]
    assert chosen.every_m == pytest.approx(result.trip.distance_m / 100)
    assert "2 of 3 profiles are written with a row every" in chosen.note


def test_rows_that_are_far_apart_are_told_without_an_exponent():
    """It was "a row every 1e+03 m"."""
    far = make_result(replace(railway_trip(), track=replace(railway_trip().track, length_m=2e5), destination_m=1.01e5),
                      [24.0, 20.0])  # fmt: skip
    assert " with a row every 1000 m, " in choose_runs(far, most_rows=1).note


def test_points_that_are_not_summed_up_lack_what_their_rows_say(result, tmp_path):
    content = write_results(result, tmp_path, PROVENANCE, [VERDICT] * 3, pictures=[], time_s=0.0).content
    assert content["fastest"]["peak_power_kw"] > 0.0
    for point in content["front"]:
        assert point["peak_power_kw"] is None
        assert set(point["balance"].values()) == set(point["ride"].values()) == {None}
        assert point["energy_kwh"] > 0.0
    assert energy_table(content) == ""
    assert "→ –" in power_and_cost(content)
    lines = (tmp_path / "front.csv").read_text().splitlines()
    assert lines[1].count(",,") > 0


def test_verdicts_come_from_the_result_unless_given(result, tmp_path):
    write_results(result, tmp_path, PROVENANCE)
    content = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
    assert [point["replay"]["time_error_pct"] for point in content["front"]] == [
        verdict.time_error_pct for verdict in result.verify()
    ]


def test_a_toy_and_a_single_point_are_written_too(tmp_path):
    write_results(make_result(toy_trip(), [0.6]), tmp_path, PROVENANCE, [VERDICT])
    assert {path.name for path in tmp_path.iterdir()} == NAMES


def test_failed_drawing_leaves_the_folder_as_it_was(result, tmp_path):
    broken = replace(result, _found=None)
    with pytest.raises(AttributeError):
        write_results(broken, tmp_path / "out", PROVENANCE, [VERDICT] * 3)
    assert list(tmp_path.iterdir()) == []


def test_full_disk_leaves_old_files_and_no_drafts(tmp_path, monkeypatch):
    (tmp_path / "a").write_bytes(b"old")
    write_bytes = Path.write_bytes

    def full_disk(self, data):
        if ".b." in self.name:
            write_bytes(self, data[:1])
            raise OSError(28, "No space left on device")
        return write_bytes(self, data)

    monkeypatch.setattr(Path, "write_bytes", full_disk)
    with pytest.raises(InputError, match="No space left on device"):
        write_files(tmp_path, {"a": b"new", "b": b"new"})
    with pytest.raises(InputError, match="No space left on device"):
        write_files(tmp_path / "new" / "deeper", {"b": b"new"})
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_bytes() == b"old"


def test_interruption_leaves_no_drafts(tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_files(tmp_path, {"a": b"new"})
    assert list(tmp_path.iterdir()) == []


def test_out_dir_that_cannot_be_a_folder(result, tmp_path):
    (tmp_path / "file").write_text("text")
    for target in (tmp_path / "file", tmp_path / "file" / "sub"):
        with pytest.raises(InputError, match="cannot be written") as caught:
            write_results(result, target, PROVENANCE, [VERDICT] * 3)
        assert str(target) in str(caught.value)
        with pytest.raises(InputError, match="is not a folder"):
            check_writable(target)


def test_check_writable_accepts_a_new_folder_and_leaves_no_trace(tmp_path):
    check_writable(tmp_path / "a" / "b")
    assert list(tmp_path.iterdir()) == []


def test_check_writable_without_permission(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(InputError, match="no permission"):
        check_writable(tmp_path)


def test_provenance_says_where_a_result_comes_from(tmp_path):
    source = tmp_path / "line.json"
    source.write_bytes(b"{}")
    trip = railway_trip()
    about = make_provenance(
        {"points": 60, "limit": float("inf"), "out": tmp_path}, {"track": source, "train": trip.train}, 1.5
    )
    json.dumps(about, allow_nan=False)
    assert about["options"] == {"points": 60, "limit": None, "out": str(tmp_path)}
    assert about["inputs"]["track"] == {"file": "line.json", "sha256": hashlib.sha256(b"{}").hexdigest()}
    assert about["inputs"]["train"]["name"] == "Test train"
    assert set(about["machine"]) == {"platform", "processor", "cores"}
    assert about["machine"]["cores"] >= 1
    assert about["elapsed_s"] == 1.5
    assert about["utc"].endswith("+00:00")
    assert {"tgvdp", "python", "numpy", "numba"} <= set(about)


def test_hash_of_a_model_changes_with_its_values():
    train = railway_trip().train
    hashes = {
        make_provenance({}, {"train": one}, 0.0)["inputs"]["train"]["sha256"]
        for one in (train, replace(train), replace(train, mass_kg=1.0))
    }
    assert len(hashes) == 2


def test_provenance_of_a_missing_file_names_it(tmp_path):
    with pytest.raises(InputError, match=r"gone\.json: cannot be read"):
        make_provenance({}, {"track": tmp_path / "gone.json"}, 0.0)


def test_importing_the_report_is_cheap():
    code = "import tgvdp.report, sys; print(sorted({'matplotlib', 'numba', 'numpy'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_unknown_names_of_the_report():
    import tgvdp.report

    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = tgvdp.report.nothing
    assert set(tgvdp.report.__all__) == {name for name in tgvdp.report.__all__ if getattr(tgvdp.report, name)}


def test_pictures_for_which_there_was_no_time_are_named(result, tmp_path):
    written = write_results(result, tmp_path, PROVENANCE, [VERDICT] * 3, pictures=["png"], drawn=dict)
    assert written.undrawn == len(pictures_of(result))
    assert written.content["warning"] == f"the time limit left no time for {written.undrawn} pictures"
    assert json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))["warning"] == written.content["warning"]
    assert front_files(["png"], -1.0, result, PROVENANCE, None) == {}


def test_a_pipe_is_written_into_and_a_link_stays_one(tmp_path):
    """They were replaced by files, and who read the pipe got nothing; as root that took a device with it."""
    pipe, link = tmp_path / "pipe", tmp_path / "link"
    os.mkfifo(pipe)
    link.symlink_to("elsewhere/file")
    (tmp_path / "elsewhere").mkdir()
    with ThreadPoolExecutor(1) as reader:
        read = reader.submit(pipe.read_bytes)
        write_files(tmp_path, {"pipe": b"through", "link": b"behind"})
        assert read.result(timeout=10.0) == b"through"
    assert pipe.is_fifo()
    assert link.is_symlink() and (tmp_path / "elsewhere" / "file").read_bytes() == b"behind"
    assert not [one for one in tmp_path.rglob("*.tmp")]


def test_only_what_would_be_lost_is_in_the_way(tmp_path):
    file, link, pipe = tmp_path / "file", tmp_path / "link", tmp_path / "pipe"
    file.touch()
    link.symlink_to("nowhere")
    os.mkfifo(pipe)
    for taken in (file, link):
        with pytest.raises(InputError, match="exists already"):
            check_new(taken, force=False)
        check_new(taken, force=True)
    for force in (False, True):
        with pytest.raises(InputError, match="is a folder, not a file"):
            check_new(tmp_path, force=force)
    for free in (pipe, tmp_path / "none", os.devnull):
        check_new(free, force=False)
