"""A server of the explorer for tests, and what its page asks for."""

import contextlib
import time

from starlette.testclient import TestClient

from tgvdp.explorer.compute.asked import Asked
from tgvdp.explorer.limits import Limits
from tgvdp.explorer.server.app import Explorer, make_app

HOST = "http://127.0.0.1"
ORIGIN = {"origin": HOST}
#: A short trip on a flat line: three points, a fraction of a second.
SHORT = {"track": "flat-100km", "options": {"to_m": 3000.0, "points": 3}}
#: A search that drowns: nothing but its time limit ends it.
ENDLESS = {
    "track": "flat-100km",
    "options": {
        "method": "best-first",
        "dominance": False,
        "bounds": False,
        "time_limit_s": 300.0,
        "max_labels": 10**9,
    },
}


@contextlib.contextmanager
def served(exhibits=(), asked=None, **limits):
    """A client of a server with some limits; no process of it is left behind."""
    explorer = Explorer(exhibits, None if asked is None else Asked(**asked), limits=Limits(**limits))
    with TestClient(make_app(explorer), base_url=HOST) as client:
        client.explorer = explorer
        yield client
    assert explorer.processes.alive == []


def ask(client, **asked):
    """Queue a run; returns what the server says of it."""
    answer = client.post("/api/runs", json=asked, headers=ORIGIN)
    assert answer.status_code == 202, answer.text
    return answer.json()


def wait_for(client, run_id, *states, within_s=300.0):
    """Wait until a run is in one of some states."""
    end = time.monotonic() + within_s
    while time.monotonic() < end:
        run = client.get(f"/api/runs/{run_id}").json()
        if run["state"] in states:
            return run
        time.sleep(0.02)
    raise AssertionError(f"run {run_id} is still {run['state']}: {run}")
