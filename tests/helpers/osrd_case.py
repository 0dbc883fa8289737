"""A small OSRD rolling stock, made by hand: 200 t, two modes, one conditional curve."""

OSRD_TRAIN = {
    "railjson_version": "3.3",
    "name": "toy",
    "locked": False,
    "length": 150.0,
    "mass": 200_000.0,
    "max_speed": 40.0,
    "startup_time": 10.0,
    "startup_acceleration": 0.05,
    "comfort_acceleration": 0.25,
    "inertia_coefficient": 1.06,
    "const_gamma": 0.5,
    "loading_gauge": "G1",
    "rolling_resistance": {"type": "davis", "A": 2000.0, "B": 36.0, "C": 6.48},
    "effort_curves": {
        "default_mode": "25000V",
        "modes": {
            "thermal": {
                "curves": [],
                "default_curve": {"speeds": [0, 10, 40], "max_efforts": [100_000, 80_000, 20_000]},
                "is_electric": False,
            },
            "25000V": {
                "curves": [
                    {
                        "cond": {
                            "comfort": "AIR_CONDITIONING",
                            "electrical_profile_level": None,
                            "power_restriction_code": "C1",
                        },
                        "curve": {"speeds": [0, 40], "max_efforts": [150_000, 50_000]},
                    }
                ],
                "default_curve": {"speeds": [0, 20, 30], "max_efforts": [200_000, 200_000, 100_000]},
                "is_electric": True,
            },
        },
    },
    "power_restrictions": {"C1": "1"},
    "energy_sources": [],
    "supported_signaling_systems": ["BAL"],
}

#: A path of 10 km with a ramp, a curve, a change of system and three operational points, as OSRD's services answer.
OSRD_PATH = {
    "name": "A to C",
    "length": 10_000_000,
    "path_properties": {
        "slopes": {"boundaries": [2_000_000, 6_000_000], "values": [0.0, 12.5, -4.0]},
        "curves": {"boundaries": [3_000_000, 3_500_000], "values": [0.0, -800.0, 0.0]},
        "electrifications": {
            "boundaries": [4_000_000, 4_200_000, 4_500_000],
            "values": [
                {"type": "electrification", "voltage": "1500V"},
                {"type": "neutral_section", "lower_pantograph": False},
                {"type": "neutral_section", "lower_pantograph": True},
                {"type": "electrification", "voltage": "25000V"},
            ],
        },
        "geometry": {"type": "LineString", "coordinates": [[0.0, 0.0], [0.1, 0.0]]},
        "operational_points": [
            {"id": "a", "position": 0, "part": {}, "is_passenger_station": True},
            {"id": "b", "position": 5_000_000, "part": {}, "is_passenger_station": True},
            {"id": "junction", "position": 5_500_000, "part": {}, "is_passenger_station": False},
        ],
        "zones": {"boundaries": [], "values": ["zone"]},
    },
    "mrsp": {
        "boundaries": [1_000_000, 7_000_000],
        "values": [
            {"speed": 20.0, "source": {"speed_limit_source_type": "unknown_tag"}},
            {"speed": 40.0, "source": None},
            {"speed": 30.0},
        ],
    },
}

#: The same path with the schedule of a train on it.
OSRD_SCHEDULE = OSRD_PATH | {
    "pathfinding": {"length": 10_000_000, "path_item_positions": [0, 2_000_000, 5_000_000, 7_000_000, 10_000_000]},
    "train_schedule": {
        "train_name": "T1",
        "rolling_stock_name": "toy",
        "start_time": "2026-01-02T08:00:00Z",
        "path": [{"id": "a", "track": "t", "offset": 0}, {"key": "b"}, {"id": "c"}, {"id": "d"}, {"id": "e"}],
        "schedule": [
            {"at": "a", "stop_for": "P0D"},
            {"at": "b", "arrival": "PT1M40S"},
            {"at": "c", "arrival": "PT5M", "stop_for": "PT30S", "reception_signal": "OPEN"},
            {"at": "e", "arrival": "PT10M", "stop_for": "PT0S"},
        ],
        "margins": {"boundaries": [], "values": ["0%"]},
    },
}
