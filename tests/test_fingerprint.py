"""Results to the bit: fronts, certificates and paths of the catalog and of generated trips, as they were recorded.

For moves of code that must not move a single bit. ``python -m tests.test_fingerprint`` records today's results anew:
a change that means to alter them does so, and says it in its commit. Only the public interface is used, so that every
file may move. On another kind of machine or with other versions of numba and numpy, whose last bits differ, totals are
compared instead, to 1e-5: a last bit may decide whether a point of a costate is kept, and moves energies by 1e-6 then.
"""

import hashlib
import json
import math
import warnings
from pathlib import Path

import llvmlite.binding
import numba
import numpy as np
import pytest

import tgvdp

RECORD = Path(__file__).with_name("fingerprint.json")
MACHINE = f"{llvmlite.binding.get_host_cpu_name()}, numba {numba.__version__}, numpy {np.__version__}"

GENERATED = tuple(range(24))
CATALOG = {
    "default": ("tgv", "lgv-100km", {}),
    "level": ("alstom-emu", "flat-100km", {}),
    "pantograph": ("alstom-emu", "lgv-100km", {"energy": "pantograph"}),
    "map": ("alstom-emu", "flat-100km", {"energy": "alstom-map", "points": 12}),
    "osrd": ("tgv", "lgv-100km", {"convention": "osrd", "points": 20}),
    "trainruns": ("alstom-emu", "lgv-100km", {"convention": "trainruns", "points": 8}),
    "strip": ("tgv", "lgv-100km", {"mass_model": "strip", "limits": "tail", "curves": "roeckl", "points": 20}),
    "section": ("alstom-emu", "lgv-100km", {"origin_m": 20e3, "destination_m": 41e3, "end_speed_mps": 20.0}),
    "targets": ("tgv", "lgv-100km", {"at_margin": (0.03, 0.05, 0.1)}),
    "clean": ("alstom-emu", "flat-100km", {"points": 6, "clean": True}),
    "exact": ("tgv", "lgv-100km", {"method": "exact", "segment_m": 5000.0, "speeds": 30}),
    "exact pantograph": (
        "alstom-emu",
        "flat-100km",
        {"method": "exact", "segment_m": 10e3, "speeds": 24, "energy": "pantograph"},
    ),
    "best-first": ("tgv", "lgv-100km", {"method": "best-first", "segment_m": 10e3, "speeds": 16, "paths": 20}),
    "best-first time": (
        "alstom-emu",
        "flat-100km",
        {"method": "best-first", "segment_m": 10e3, "speeds": 12, "heuristic": "time", "paths": 10},
    ),
}


def generated(seed):
    """A realistic train on a realistic line, of a kind that the seed says: limits, ramps, curves, neutral sections."""
    rng = np.random.default_rng([2026, seed])
    mass = rng.uniform(120e3, 900e3)
    force = mass * rng.uniform(0.35, 0.8)
    train = tgvdp.Train(
        mass_kg=mass,
        length_m=rng.uniform(50.0, 400.0),
        rotating_mass_factor=rng.uniform(1.04, 1.12),
        traction=tgvdp.EffortCurve.from_caps(force, mass * rng.uniform(8.0, 20.0)),
        braking=tgvdp.EffortCurve.from_caps(0.6 * force, mass * rng.uniform(6.0, 15.0)),
        friction_brake_n=mass * rng.uniform(0.5, 1.0),
        davis_a_n=mass * rng.uniform(0.008, 0.02),
        davis_b_n_per_mps=mass * rng.uniform(0.0, 3e-4),
        davis_c_n_per_mps2=mass * rng.uniform(1e-5, 4e-5),
        max_deceleration_mps2=(math.inf, 0.7)[seed % 2],
        traction_efficiency=0.87,
        regeneration_efficiency=0.8,
        auxiliary_power_w=mass * 0.4,
    )
    length = 10 ** rng.uniform(3.2, 5.0)
    limits = [(0.0, rng.uniform(20.0, 60.0))]
    limits += [(x, rng.uniform(15.0, 60.0)) for x in np.sort(rng.uniform(0.0, length, seed % 7))]
    gradients = [(0.0, 0.0)] + [
        (x, rng.uniform(-15.0, 12.0)) for x in np.sort(rng.uniform(0.0, length, 3 * (seed % 5)))
    ]
    curves = [
        (x, r, r) for x, r in zip((0.0, *np.sort(rng.uniform(0, length, 3))), rng.uniform(400, 3000, 4), strict=True)
    ]
    neutral = [(0.6 * length, 0.01 * length, seed % 8 == 3)] if seed % 4 == 3 else []
    track = tgvdp.Track(
        length_m=length,
        speed_limits=tuple(limits),
        gradients=tuple(gradients),
        curves=tuple(curves),
        neutral_sections=tuple(neutral),
    )
    options = {
        "points": 12,
        "energy": ("wheel", "pantograph")[seed // 2 % 2],
        "mass_model": ("point", "strip")[seed % 3 == 2],
        "curves": ("none", "800/R")[seed % 5 == 1],
    }
    return train, track, options


def cases():
    for name, (train, track, options) in CATALOG.items():
        yield name, (lambda a=train, b=track, c=options: (tgvdp.load_train(a), tgvdp.load_track(b), c))
    for seed in GENERATED:
        yield f"generated {seed}", (lambda s=seed: generated(s))


CASES = dict(cases())


def fingerprint(train, track, options):
    """Totals to be read, and one hash of every bit of the front, its profiles, its bounds and its verdicts."""
    digest = hashlib.sha256()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        try:
            result = tgvdp.search(train, track, **options)
        except tgvdp.TgvdpError as error:
            return {
                "error": type(error).__name__,
                "totals": [],
                "sha256": hashlib.sha256(str(error).encode()).hexdigest(),
            }
        certificate = result.certify(time_limit_s=1e6)

    def add(values):
        digest.update(np.ascontiguousarray(values, dtype=np.float64).tobytes())

    add([result.fastest.time_s, result.fastest.energy_j])
    for values in (result.front.time_s, result.front.energy_j, result.path_time_s, result.path_energy_j):
        add(values)
    if result.price_kwh_per_min is not None:
        add(result.price_kwh_per_min)
    add(certificate.gap_pct)
    for index in range(len(result.front)):
        profile = result.profile(index)
        for values in (profile.position_m, profile.speed_mps, profile.time_s, profile.force_n, profile.energy_j):
            add(values)
        add(profile.regime)
    verdicts = result.verify()
    add([(verdict.time_error_pct, verdict.energy_error_pct, verdict.ok) for verdict in verdicts])
    gap_pct = np.asarray(certificate.gap_pct, dtype=float)
    totals = [
        result.fastest.time_s,
        float(result.front.time_s.sum()),
        float(result.front.energy_j.sum()),
        float(100.0 + np.nan_to_num(gap_pct, posinf=0.0, neginf=0.0).sum()),
    ]
    return {"points": len(result.front), "totals": totals, "sha256": digest.hexdigest()}


@pytest.mark.parametrize("name", CASES)
def test_results_are_those_recorded(name):
    record = json.loads(RECORD.read_text())
    train, track, options = CASES[name]()
    found, recorded = fingerprint(train, track, options), record["cases"][name]
    if record["machine"] == MACHINE:
        assert found == recorded
    else:
        assert {**found, "totals": 0, "sha256": 0} == {**recorded, "totals": 0, "sha256": 0}
        assert found["totals"] == pytest.approx(recorded["totals"], rel=1e-5)


def main():
    found = {name: fingerprint(*case()) for name, case in CASES.items()}
    RECORD.write_text(json.dumps({"machine": MACHINE, "cases": found}, indent=1) + "\n")


if __name__ == "__main__":
    main()
