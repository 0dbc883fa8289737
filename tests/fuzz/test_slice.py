"""A small slice of what ``make fuzz`` tries: no signal, no traceback, no raw warning, no hang."""

import subprocess
import sys
from itertools import islice
from pathlib import Path

import pytest

from fuzz.cases import FACTORS, loads, mutations, others, slips
from fuzz.inputs import leaves, number_of, originals, pieces

ROOT = Path(__file__).resolve().parents[2]


def test_a_slice_of_slips_and_mutations_ends_in_order():
    command = [sys.executable, "-m", "fuzz", "--cases", "20", "--seconds", "600"]  # by processor time a minute in all
    done = subprocess.run(command, check=False, cwd=ROOT, capture_output=True, text=True, timeout=3000)
    assert done.returncode == 0, done.stdout + done.stderr
    for what in ("slips", "mutations", "loads", "others"):
        assert f"{what}: 20 cases, 0 failed" in done.stdout


def test_every_kind_of_number_is_slipped_by_every_factor():
    names = [case.name for case in slips() if case.file == "tgv.toml"]
    assert "tgv.toml: train.mass_t × 0.001" in names
    assert "tgv.toml: train.traction.power_kw × 1e+06" in names
    assert len(names) == len(set(names)) == len(FACTORS) * 16
    rows = {case.name.partition(" × ")[0] for case in slips() if "gradient_permil" in case.name}
    assert "lgv-100km.toml: track.gradients[0].gradient_permil" in rows
    assert len([name for name in rows if name.startswith("lgv-100km.toml")]) == 3  # first, middle, last


def test_mutations_have_names_that_make_them_again():
    for made in (mutations, loads, others):
        once, again, other = (list(islice(made(seed), 50)) for seed in (3, 3, 4))
        assert once == again
        assert [case.content for case in once] != [case.content for case in other]


def test_other_commands_are_tried_with_what_they_read():
    commands = {command[0] for case in islice(others(0), 200) for command in case.commands}
    assert commands == {"journey", "score", "compare", "solve", "formulate", "bench"}


@pytest.mark.parametrize("original", originals(), ids=lambda original: original.name)
def test_all_files_hold_numbers_and_can_be_written(original):
    assert any(number_of(value) is not None for _, value in leaves(original.tree))
    assert original.write(original.tree)


def test_numbers_of_xml_and_tables_stand_alone():
    assert pieces('<a pos="12.5" id="t1"/>') == ['<a pos="', "12.5", '" id="t1"/>']
