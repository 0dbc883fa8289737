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
