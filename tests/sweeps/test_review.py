"""``tgvdp validate SPEC``: what a sweep would run, or what is wrong with its file."""

import pytest

from tests.helpers.sweep_case import SPEC, write_case
from tgvdp.cli import main


def test_validate_says_what_a_sweep_runs(tmp_path, capsys):
    path = write_case(tmp_path, f'{SPEC}[[zip]]\nreverse = [false, true]\n"track.altitude_m" = [0, 400]\n')
    assert main(["validate", str(path)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    varied = "3 train.mass_t × 3 wind_kmh × 2 reverse and track.altitude_m"
    assert out.splitlines() == [
        f"{path}: sweep spec (spec)",
        f"  scenarios                     72, 1 train × 4 sections of 2 lines × {varied}",
        "  trains                        metro",
        "  lines                         east, west",
        "  train.mass_t                  180, 200, 220",
        "  wind_kmh                      0, 10, 20",
        "  reverse and track.altitude_m  (False, 0), (True, 400)",
        "  run points                    5",
        "  run max_margin_pct            10.0",
        "  plausibility of train metro: 1 warning",
        "    warning  rotating mass factor 1 (usual 1.02 to 1.35: rotating masses left out?)",
    ]


def test_validate_reviews_the_trains_and_lines_of_a_sweep(tmp_path, capsys):
    path = write_case(tmp_path)
    (tmp_path / "metro.toml").write_text((tmp_path / "metro.toml").read_text().replace("= 200", "= 2"))
    assert main(["validate", "-v", str(path)]) == 0
    out = capsys.readouterr().out
    assert "  plausibility of train metro: " in out
    assert "    warning  mass 2 t" in out
    assert "  plausibility of track west: no warnings" in out


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("[0, 10, 20]", "[0, 'much']", "spec.toml: product.wind_kmh: must be a number, got 'much'"),
        ('lines = ["lines"]\n', "", "spec.toml: missing field 'lines'"),
        ('["metro.toml"]', '["absent.toml"]', "absent.toml: no such file"),
        ("[0, 10, 20]", "10", "spec.toml: product.wind_kmh: must be a list, got 10"),
        ("[product]", "[[zip]]\nreverse = true\n[product]", "spec.toml: zip[0].reverse: must be a list, got True"),
        (SPEC, 'trains = "tgv"', "spec.toml: holds none of train, track, map and run"),
    ],
)
def test_validate_says_what_is_wrong_with_a_spec(tmp_path, capsys, before, after, message):
    path = write_case(tmp_path, SPEC.replace(before, after))
    assert main(["validate", str(path)]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["spec.toml#east"], "spec.toml: is the spec of a sweep, of which 'east' chooses nothing"),
        (["spec.toml", "--line-speed", "30"], "spec.toml: is the spec of a sweep: a line speed would change nothing"),
    ],
)
def test_what_a_spec_has_no_use_for_is_refused(tmp_path, monkeypatch, capsys, words, message):
    monkeypatch.chdir(write_case(tmp_path).parent)
    assert main(["validate", *words]) == 3
    assert capsys.readouterr().err == f"tgvdp: error: {message}\n"


def test_a_spec_where_a_scenario_is_meant_and_the_other_way_round(tmp_path, capsys):
    path = write_case(tmp_path)
    for words in (["search", "--scenario"], ["search", "--train"], ["convert"]):
        out = [str(tmp_path / "a.json")] if words == ["convert"] else []
        assert main([*words, str(path), *out]) == 3
        assert capsys.readouterr().err == f"tgvdp: error: {path}: is the spec of a sweep, which tgvdp sweep runs\n"
    train = tmp_path / "metro.toml"
    assert main(["sweep", str(train), "--dry-run"]) == 3
    message = "is no spec of a sweep: it names neither trains nor lines"
    assert capsys.readouterr().err == f"tgvdp: error: {train}: {message}\n"
