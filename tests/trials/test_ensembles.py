"""Medians over families, their bootstrap intervals, and growth with the size."""

import numpy as np
import pytest

from tgvdp.trials.ensembles import ensembles, family_of, scaling, variants
from tgvdp.trials.pivot import growth_table, pivot


def row(problem, steps, word, p, sweeps, seconds=1.0):
    return {
        "Problem": problem, "N": steps, "Workflow": word, "p_success": p, "p from": "attempts",
        "TTS99 sweeps": sweeps, "TTS99 s": seconds,
    }  # fmt: skip


def family(law, sizes=(6, 8, 10, 12), count=20):
    """Instances whose efforts scatter around a law of N."""
    rng = np.random.default_rng(1)
    return [
        row(f"easy-n{steps:03d}-s{i:02d}", steps, "sa:unary:sweeps=10", 0.5, law(steps) * float(np.exp(0.2 * noise)))
        for steps in sizes
        for i, noise in enumerate(rng.normal(size=count))
    ]


def test_names_of_families_and_of_variants():
    assert family_of("easy-n020-s07") == family_of("easy-n020") == "easy"
    assert family_of("my trip") == "my trip"
    words = ["sa:unary:beta=1..2:reads=5", "qaoa:unary:angles=ramp:layers=3:mixer=walls:step=0.5", "dp"]
    assert list(variants([row("a", 4, word, 1.0, 1.0) for word in words]).values()) == [
        "sa:unary", "qaoa:unary:angles=ramp:mixer=walls", "dp",
    ]  # fmt: skip
    two = [row("a", 4, word, 1.0, 1.0) for word in ("sa:unary:reads=5", "sa:unary:reads=6", "pt:unary:reads=5")]
    assert list(variants(two).values()) == ["sa:unary:reads=5", "sa:unary:reads=6", "pt:unary"]


def test_the_median_instance_and_its_interval():
    found = ensembles(family(lambda steps: 100.0 * steps))
    assert [one["N"] for one in found] == [6, 8, 10, 12] and all(one["instances"] == 20 for one in found)
    for one in found:
        assert one["TTS99 sweeps low"] < one["TTS99 sweeps"] < one["TTS99 sweeps high"]
        assert one["TTS99 sweeps"] == pytest.approx(100.0 * one["N"], rel=0.15)


def test_a_median_that_was_never_solved_is_infinite_and_said_so():
    rows = [row(f"a-n004-s{i}", 4, "sa", 0.0 if i else 0.1, np.inf if i else 50.0) for i in range(3)]
    (found,) = ensembles(rows)
    assert found["TTS99 sweeps"] == np.inf and found["solved"] == 1
    assert "solved 1 of 3" in pivot([found])


@pytest.mark.parametrize(
    ("law", "column", "slope"),
    [(lambda n: 10.0 * n**3, "power of N", 3.0), (lambda n: 10.0 ** (0.25 * n), "decades per step", 0.25)],
)
def test_growth_is_found_within_its_interval(law, column, slope):
    found = next(one for one in scaling(family(law)) if one["unit"] == "sweeps")
    assert found[f"{column} low"] <= slope <= found[f"{column} high"]
    assert found["sizes"] == "6 8 10 12" and not found["sizes without"]
    assert "| easy | `sa:unary` | sweeps |" in growth_table([found])


def test_few_sizes_or_instances_have_no_growth():
    assert scaling(family(lambda n: n, sizes=(6, 8, 10))) == []
    assert scaling(family(lambda n: n, count=3)) == []
