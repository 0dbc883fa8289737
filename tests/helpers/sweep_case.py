"""A small sweep: a metro train on two short lines, and what its folder holds."""

import hashlib
import subprocess
import sys

TRAIN = """
[train]
name = "metro"
mass_t = 200
max_speed_kmh = 80
davis_a_n = 4000
davis_b_n_per_kmh = 16
davis_c_n_per_kmh2 = 0.7
friction_brake_kn = 60
traction = { force_kn = 300, power_kw = 2500 }
braking = { force_kn = 200, power_kw = 4000 }
traction_efficiency_pct = 85
"""
LINE = """
[track]
name = "{name}"
length_m = {length_m}
stops_m = [0, {stop_m}, {length_m}]
speed_limits = [{{ from_m = 0, speed_kmh = 60 }}, {{ from_m = 400, speed_kmh = 75 }}]
gradients = [{{ from_m = 0, gradient_permil = 0 }}, {{ from_m = 600, gradient_permil = 8 }}]
"""
SPEC = """
trains = ["metro.toml"]
lines = ["lines"]
sections = "stops"

[run]
points = 5
max_margin_pct = 10

[product]
"train.mass_t" = [180, 200, 220]
wind_kmh = [0, 10, 20]
"""
#: 2 lines × 2 sections × 9.
COUNT = 36
#: Tables that do not depend on who solved what, and when.
TABLES = ("scenarios.parquet", "scenarios.csv", "fronts.csv", "fronts/0000.parquet")


def write_case(folder, spec=SPEC):
    """Write train, lines and spec; returns the path of the spec."""
    (folder / "lines").mkdir(parents=True)
    (folder / "metro.toml").write_text(TRAIN)
    for name, stop_m, length_m in (("east", 900, 2000), ("west", 1100, 1900)):
        (folder / "lines" / f"{name}.toml").write_text(LINE.format(name=name, stop_m=stop_m, length_m=length_m))
    path = folder / "spec.toml"
    path.write_text(spec)
    return path


def command(*words):
    """Command line of a sweep in a process of its own."""
    return [sys.executable, "-m", "tgvdp", "sweep", *map(str, words)]


def run(*words, **options):
    """Run a sweep to its end."""
    return subprocess.run(command(*words), capture_output=True, text=True, check=False, timeout=600, **options)


def digests(out):
    """Hashes of the tables that have to be the same each time."""
    return {name: hashlib.sha256((out / name).read_bytes()).hexdigest() for name in TABLES}
