"""Small files in the formats that tgvdp reads, made by hand, and what they hold in SI."""

import copy
import io
import json

from ruamel.yaml import YAML


def yaml_text(tree):
    """A tree as YAML in block style."""
    text = io.StringIO()
    writer = YAML(typ="safe", pure=True)
    writer.default_flow_style = False
    writer.dump(tree, text)
    return text.getvalue()


def quantity(value, unit):
    return {"unit": unit, "value": value}


METADATA = {"id": "toy", "library version": "TTOBench v1.4", "created by": "the tests"}

TTOBENCH_TRAIN = {
    "metadata": METADATA,
    "num seats": quantity(300, "-"),
    "length": quantity(150, "m"),
    "mass": quantity(200, "t"),
    "rho": quantity(6, "%"),
    "max traction power": quantity(4, "MW"),
    "max reg braking power": quantity(3000, "kW"),
    "max traction force": quantity(200, "kN"),
    "max reg braking force": quantity(150_000, "N"),
    "max pn braking force": quantity(100, "kN"),
    "max acceleration": quantity(1.0, "m/s^2"),
    "max speed": quantity(144, "km/h"),
    "rolling resistance r0": quantity(2.0, "kN"),
    "rolling resistance r1": quantity(0.01, "kN/(km/h)"),
    "rolling resistance r2": quantity(0.0005, "kN/(km/h)^2"),
    "efficiency traction": quantity(90, "%"),
}

#: With what published trains of version 1.4 have, as the library's own check of trains wants it.
TTOBENCH_TRAIN_14 = TTOBENCH_TRAIN | {
    "tunnel resistance": {
        "units": {"cross section": "m^2", "coefficient": "kN/(km/h)^2"},
        "values": [[22.5, 0.0011], [40, 0.0005]],
    },
    "ETCS braking data": {
        "A_brake_emergency": {
            "units": {"velocity": "km/h", "deceleration": "m/s^2"},
            "values": [[0, 1.0], [72, 0.9]],
        },
        "A_brake_service": {"units": {"velocity": "m/s", "deceleration": "m/s^2"}, "values": [[0, 0.7], [20, 0.6]]},
        "K_dry_rst": quantity(0.8, "-"),
        "K_wet_rst": quantity(0.7, "-"),
        "T_traction": quantity(1.5, "s"),
        "T_be": quantity(3, "s"),
        "T_bs": quantity(4, "s"),
        "v_uncertainty": quantity(2, "%"),
    },
}

TTOBENCH_TRACK = {
    "metadata": METADATA,
    "altitude": quantity(100, "m"),
    "stops": {"unit": "m", "values": [0.0, 4000.0, 10000.0]},
    "speed limits": {
        "units": {"position": "m", "velocity": "km/h"},
        "values": [[0.0, 90], [3000.0, 120]],
    },
    "gradients": {"units": {"position": "m", "slope": "permil"}, "values": [[0.0, 5.0], [2000.0, -4.0]]},
    "curvatures": {
        "units": {"position": "m", "radius at start": "m", "radius at end": "m"},
        "values": [[0.0, "infinity", "infinity"], [100.0, "infinity", -400.0], [300.0, 500.0, 500.0]],
    },
    "tunnels": {
        "units": {"position": "m", "length": "m", "cross section": "m^2"},
        "values": [[7000.0, 1050.0, 40.0]],
    },
}

JOURNEY = {
    "metadata": METADATA | {"id": "toy_01", "associated track": "toy"},
    "timing points": {
        "units": {
            "position": "km",
            "lower time constraint": "min",
            "upper time constraint": "s",
            "lower speed constraint": "km/h",
            "upper speed constraint": "m/s",
        },
        "values": [
            [0, 0, 30, 0, 0],
            [1, None, None, None, None],
            [2, 2, 150, 36, 20],
            [4, 5, 330, 0, 0],
            [4, 6, None, 0, 0],
            [10, None, 900, 0, 0],
        ],
    },
}

SCENARIO = """
name = "trip"

[train]
mass_t = 200
max_speed_kmh = 144
davis_a_n = 2000
davis_b_n_per_kmh = 10
davis_c_n_per_kmh2 = 0.5
friction_brake_kn = 100
traction = { force_kn = 200, power_kw = 4000 }
braking = { points = [{ speed_kmh = 0, effort_kn = 0 }, { speed_kmh = 36, effort_kn = 100 }] }

[track]
length_m = 10_000
speed_limits = [{ from_m = 0, speed_kmh = 90 }, { from_m = 3_000, speed_kmh = 120 }]
gradients = [{ from_m = 0, gradient_permil = 5 }]
curves = [{ from_m = 0, radius_start_m = "infinity", radius_end_m = -400 }]
tunnels = [{ from_m = 7_000, length_m = 1_050, cross_section_m2 = 40 }]

[run]
from_m = 1_000
to_m = 9_000
start_speed_kmh = 36
method = "exact"
points = 20
dominance = false
"""


def changed(tree, path, value):
    """Copy a tree with one value replaced, or removed where the new value is ``...``."""
    tree = copy.deepcopy(tree)
    *above, last = path
    table = tree
    for step in above:
        table = table[step]
    if value is ...:
        del table[last]
    else:
        table[last] = value
    return tree


def write_json(path, tree):
    path.write_text(json.dumps(tree), encoding="utf-8")
    return path
