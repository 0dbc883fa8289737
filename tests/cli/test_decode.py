"""``tgvdp decode``: samples from outside, in each form, and files that are none."""

import json

import numpy as np
import pytest

from tgvdp.cli import main
from tgvdp.formulations.problem.reading import read_instance
from tgvdp.formulations.qubo.encodings import encode
from tgvdp.instances import find
from tgvdp.solvers.samplers.bqm import bqm_of

#: easy-n004 in unary: bits t1_1, t2_1, t2_2, t3_1; an optimum, and the standing train.
LABELS = ("t1_1", "t2_1", "t2_2", "t3_1")
OPTIMUM, NOTHING = (1, 1, 0, 0), (0, 0, 0, 0)


@pytest.fixture
def decoded(tmp_path, capsys):
    def run(name, content, *words):
        path = tmp_path / name
        path.write_text(content)
        code = main(["decode", "easy-n004", str(path), *words, "--json"])
        captured = capsys.readouterr()
        return code, json.loads(captured.out) if captured.out else captured.err

    return run


def forms():
    dimod = pytest.importorskip("dimod")
    bqm = bqm_of(encode(read_instance(find("easy-n004")), "unary").qubo)
    strings = [dict(zip(LABELS, bits, strict=True)) for bits in (OPTIMUM, NOTHING)]
    sampleset = dimod.SampleSet.from_samples_bqm(strings, bqm)
    sampleset = dimod.SampleSet.from_samples(strings, "BINARY", sampleset.record.energy, num_occurrences=[3, 2])
    rows = "".join(f"{count},{','.join(map(str, bits[::-1]))}\n" for count, bits in ((3, OPTIMUM), (2, NOTHING)))
    spins = rows.replace("0", "-1")
    return {
        "set.json": json.dumps(sampleset.to_serializable()),
        "spins.json": json.dumps(sampleset.change_vartype("SPIN", inplace=False).to_serializable()),
        "counts.json": json.dumps({"0011": 3, "0000": 2}),
        "table.csv": f"count,{','.join(LABELS[::-1])}\n{rows}",
        "spins.csv": f"count,{','.join(LABELS[::-1])}\n{spins}",
    }


@pytest.mark.parametrize("name", ["set.json", "spins.json", "counts.json", "table.csv", "spins.csv"])
def test_every_form_gives_the_same(decoded, name):
    code, found = decoded(name, forms()[name], "--encoding", "unary")
    assert code == 0
    assert found["feasible"] and found["replay"]["feasible"] and not found["optimal"]
    assert found["objective"] == 0.7
    assert found["speeds_dv"] == [0, 1, 1, 0, 0]
    assert [found["details"][key] for key in ("reads", "feasible_reads", "best_reads")] == [5, 3, 3]


def test_nothing_feasible_ends_with_5_and_the_table_tells_the_reads(decoded, tmp_path, capsys):
    assert decoded("counts.json", '{"0000": 4}')[0] == 5
    (tmp_path / "good.json").write_text('{"0011": 1, "0000": 3}')
    assert main(["decode", "easy-n004", str(tmp_path / "good.json")]) == 0
    assert "4, 1 feasible; 1 reach this objective, 25.0 % of all" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("content", "part"),
    [
        ('{"00110": 1}', "no string of the 4 bits"),
        ('{"0011": 0}', "above 0"),
        ("{}", "holds neither"),
        ("[1, 2]", "holds neither"),
        ('{"type": "SampleSet"}', "damaged SampleSet"),
        ("", "no column"),
        ("t1_1,t2_1,t2_2\n1,1,0\n", "no column 't3_1'"),
        ("t1_1,t2_1,t2_2,t3_1\n", "holds no sample"),
        ("t1_1,t2_1,t2_2,t3_1\n1,1,0\n", "line 2"),
        ("t1_1,t2_1,t2_2,t3_1\n1,1,0,0,1\n", "line 2: has more values than the 4 columns"),
        ("t1_1,t2_1,t2_2,t3_1\n1,1,0,2\n", "bits must be 0 and 1"),
        ("t1_1,t2_1,t2_2,t3_1,count\n1,1,0,0,-1\n", "above 0"),
        (f"t1_1,t2_1,t2_2,t3_1,count\n1,1,0,0,{10**30}\n", "at most"),
        (f'{{"0011": {10**30}}}', "at most"),
        ("t1_1,t2_1,t2_2,t3_1,t1_1\n1,1,0,0,0\n", "column 't1_1' twice"),
        ("t1_1,t2_1,t2_2,t3_1\n" + "1" * 200_000 + ",1,0,0\n", "line"),
        ("[" * 100_000, "nested too deeply"),
    ],
)
def test_other_files_are_one_line(decoded, content, part):
    code, err = decoded("wrong", content)
    assert code == 3
    assert part in err and "wrong" in err and err.count("\n") == 1


@pytest.mark.parametrize(
    ("values", "counts", "part"),
    [
        ([], [], "holds no sample"),
        ([OPTIMUM], [-3], "above 0"),
        ([(256, 0, 0, 0)], [1], "bits must be 0 and 1"),
        ([(1, 0.5, 0, 0)], [1], "bits must be 0 and 1"),
    ],
)
def test_a_sample_set_of_something_else_is_refused(decoded, values, counts, part):
    dimod = pytest.importorskip("dimod")
    samples = np.array(values).reshape(-1, len(LABELS))
    sampleset = dimod.SampleSet.from_samples(
        (samples, LABELS), "REAL", np.zeros(len(samples)), num_occurrences=np.array(counts, dtype=int)
    )
    code, err = decoded("wrong", json.dumps(sampleset.to_serializable(pack_samples=False)))
    assert code == 3
    assert part in err and err.count("\n") == 1


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("vectors",), 5),
        (("vectors",), []),
        (("sample_data", "data", 0, 0), -1),
        (("vectors", "num_occurrences", "data"), 1e400),
    ],
)
def test_a_sample_set_with_a_damaged_part_is_one_line(decoded, place, value):
    dimod = pytest.importorskip("dimod")
    sampleset = dimod.SampleSet.from_samples((np.array([OPTIMUM]), LABELS), "BINARY", np.zeros(1))
    tree = json.loads(json.dumps(sampleset.to_serializable()))
    part = tree
    for key in place[:-1]:
        part = part[key]
    part[place[-1]] = value
    code, err = decoded("wrong", json.dumps(tree))
    assert code == 3
    assert "is a damaged SampleSet" in err and err.count("\n") == 1


def test_strings_of_trains_at_a_substation_are_decoded(tmp_path, capsys):
    content = {
        "id": "two",
        "params": {
            "kind": "substation", "dt_s": 1, "dv_mps": 1, "power_units": 2, "alpha": 0.5,
            "trains": [{"N": 2, "cap_units": 1, "D_units": 1}, {"N": 2, "cap_units": 1, "D_units": 1, "start": 1}],
        },
    }  # fmt: skip
    (tmp_path / "two.json").write_text(json.dumps(content))
    qubo = encode(read_instance(tmp_path / "two.json"), "unary").qubo
    lowest = int(qubo.all_energies().argmin())
    (tmp_path / "counts.json").write_text(json.dumps({f"{lowest:0{qubo.n}b}": 4}))
    assert main(["decode", str(tmp_path / "two.json"), str(tmp_path / "counts.json"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["objective"] == 0.75  # the second train takes half of what the first one brakes away
    assert found["speeds_dv"] == [0, 1, 0, 0, 1, 0]


def test_demand_instances_and_missing_files_are_refused(capsys, tmp_path):
    assert main(["decode", "demand-n004", "x"]) == 3
    assert main(["decode", "easy-n004", str(tmp_path / "absent")]) == 3
    assert capsys.readouterr().err.count("\n") == 2


def test_written_forms_hold_the_energies_of_the_qubo(tmp_path):
    from itertools import product

    qubo = encode(read_instance(find("easy-n004")), "unary").qubo
    files = {target: tmp_path / target for target in ("qs", "ising")}
    for target, path in files.items():
        assert main(["formulate", "easy-n004", "--to", target, "-o", str(path)]) == 0
    head, size, *lines = files["qs"].read_text().splitlines()
    offset = float(head.removeprefix("# ObjectiveOffset "))
    assert size == f"{qubo.n} {len(lines)}"
    matrix = np.zeros((qubo.n, qubo.n))
    for line in lines:
        i, j, value = line.split()
        matrix[int(i) - 1, int(j) - 1] = matrix[int(j) - 1, int(i) - 1] = float(value)
    ising = json.loads(files["ising"].read_text())
    for bits in product((0, 1), repeat=qubo.n):
        x = np.array(bits)
        assert offset + x @ matrix @ x == pytest.approx(float(qubo.energy(x)))
        s = dict(zip(qubo.labels, 2 * x - 1, strict=True))
        energy = ising["offset"] + sum(h * s[i] for i, h in ising["h"].items())
        assert energy + sum(value * s[i] * s[j] for i, j, value in ising["J"]) == pytest.approx(float(qubo.energy(x)))
