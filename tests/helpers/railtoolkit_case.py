"""Small railtoolkit files, made by hand: a loco, two kinds of car, a multiple unit, and two paths."""

import copy

ROLLING_STOCK = {
    "schema": "https://railtoolkit.org/schema/rolling-stock.json",
    "schema_version": "2022.05",
    "trains": [
        {"name": "Fast passenger", "id": "IC", "UUID": "00", "formation": ["loco", "coach", "coach"]},
        {"name": "Goods", "id": "G", "formation": ["loco", "loco", "wagon"]},
        {"id": "unit", "formation": ["railcar"]},
    ],
    "vehicles": [
        {
            "name": "Loco",
            "id": "loco",
            "vehicle_type": "traction unit",
            "power_type": "electric",
            "length": 20.0,
            "mass": 80.0,
            "mass_traction": 60.0,
            "speed_limit": 200,
            "rotation_mass": 1.09,
            "base_resistance": 2.5,
            "rolling_resistance": 1.5,
            "air_resistance": 4.0,
            "tractive_effort": [[0.0, 300_000], [72.0, 300_000], [72.0, 250_000], [200.0, 90_000]],
        },
        {
            "name": "Coach",
            "id": "coach",
            "vehicle_type": "passenger",
            "length": 26.4,
            "mass": 40.0,
            "load_limit": 10.0,
            "speed_limit": 180,
            "rotation_mass": 1.06,
            "base_resistance": 1.9,
            "rolling_resistance": 0.4,
            "air_resistance": 1.1,
        },
        {
            "name": "Wagon",
            "id": "wagon",
            "vehicle_type": "freight",
            "length": 14.0,
            "mass": 22.0,
            "load_limit": 58.0,
            "speed_limit": 100,
            "base_resistance": 1.4,
            "air_resistance": 5.7,
        },
        {
            "name": "Railcar",
            "id": "railcar",
            "vehicle_type": "multiple unit",
            "length": 41.7,
            "mass": 68.0,
            "load_limit": 20.0,
            "mass_traction": 34.0,
            "speed_limit": 120,
            "a_braking": -0.4,
            "rotation_mass": 1.08,
            "base_resistance": 3.0,
            "rolling_resistance": 1.4,
            "air_resistance": 3.9,
            "tractive_effort": [[0.0, 94_400], [60.0, 25_000], [120.0, 13_000]],
        },
    ],
}

#: The Intercity 2 of TrainRuns.jl (test/data/trains/longdistance.yaml, ISC) in figures: 300 kN up to 19.95 MN·km/h.
INTERCITY_2 = {
    "schema": "https://railtoolkit.org/schema/rolling-stock.json",
    "schema_version": "2022.05",
    "trains": [{"id": "IC2", "formation": ["loco", *["coach"] * 4, "control car"]}],
    "vehicles": [
        {
            "id": name, "vehicle_type": "passenger", "length": length, "mass": mass, "load_limit": 20.0,
            "speed_limit": 160, "rotation_mass": 1.06, "base_resistance": 2.0, "rolling_resistance": 0.715,
            "air_resistance": 3.64,
        }
        for name, length, mass in (("control car", 27.27, 58.0), ("coach", 26.8, 50.0))
    ] + [
        {
            "id": "loco", "vehicle_type": "traction unit", "length": 18.9, "mass": 85, "mass_traction": 85,
            "speed_limit": 160, "rotation_mass": 1.09, "base_resistance": 2.5, "air_resistance": 6.0,
            "tractive_effort": [
                [float(kmh), min(300_000, round(19.95e6 / max(kmh, 1), -1))] for kmh in range(161)
            ],
        }
    ],
}  # fmt: skip

PATHS = {
    "schema": "https://railtoolkit.org/schema/running-path.json",
    "schema_version": "2022.05",
    "paths": [
        {
            "name": "Two limits",
            "id": "two",
            "UUID": "01",
            "points_of_interest": [[999.0, "signal", "front"]],
            "characteristic_sections": [[0.0, 90, 0.0], [3000.0, 144, -5.0], [10000.0, 144, -5.0]],
        },
        {"name": "Level", "id": "level", "characteristic_sections": [[0.0, 90, 0.0], [5000.0, 90, 0.0]]},
    ],
}

PATHS_2024 = {
    "schema": "https://railtoolkit.org/schema/running-path.json",
    "schema_version": "2024.07",
    "paths": [
        {
            "name": "Two limits",
            "id": "two",
            "characteristic_sections": [
                {"position": 500.0, "speed": 90},
                {"position": 1500.0, "resistance": 3.0},
                {"position": 3500.0, "speed": 144, "resistance": -5.0},
                {"position": 10500.0},
            ],
        },
    ],
}


def vehicle_changed(index, **fields):
    """Rolling stock with fields of one vehicle replaced, or removed where the new value is ``...``."""
    tree = copy.deepcopy(ROLLING_STOCK)
    for name, value in fields.items():
        tree["vehicles"][index][name] = value
        if value is ...:
            del tree["vehicles"][index][name]
    return tree
