"""What runs in a fresh process: one front, measured from the inside, reported as JSON.

``python -m benchmarks.probe LENGTH_M POINTS REPEATS``
"""

import hashlib
import json
import sys
import time


def main(length_m: float, points: int, repeats: int) -> dict[str, float | str]:
    started = time.perf_counter()
    import tgvdp

    import_s = time.perf_counter() - started
    started = time.perf_counter()
    search = tgvdp.search
    load_s = time.perf_counter() - started

    from benchmarks.instances import synthetic_instance
    from benchmarks.timing import median_s, peak_memory_bytes

    loaded_bytes = peak_memory_bytes()
    arguments = synthetic_instance(length_m).arguments | {"points": points}
    started = time.perf_counter()
    search(**arguments)
    first_s = time.perf_counter() - started
    warm_s, result = median_s(lambda: search(**arguments), repeats)
    profiles = [result.profile(index) for index in range(len(result.front))]
    digest = hashlib.sha256(result.front.time_s.tobytes() + result.front.energy_j.tobytes())
    return {
        "import_s": import_s,
        "load_s": load_s,
        "first_s": first_s,
        "warm_s": warm_s,
        "jit_s": first_s - warm_s,
        "loaded_mb": loaded_bytes / 1e6,
        "peak_mb": peak_memory_bytes() / 1e6,
        "profile_rows": sum(len(profile.time_s) for profile in profiles),
        "points": len(profiles),
        "digest": digest.hexdigest(),
    }


if __name__ == "__main__":
    print(json.dumps(main(float(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))))
