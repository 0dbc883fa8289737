"""What strangers may not do, and what the page may: over HTTP, without a browser."""

import json
import os
import socket
import time
import urllib.request
from pathlib import Path

import pytest

from tests.helpers.browser_case import listening
from tests.helpers.explorer_case import ENDLESS, HOST, ORIGIN, SHORT, ask, served, wait_for
from tgvdp.explorer.assets import assets
from tgvdp.explorer.server.guard import POLICY, host_name
from tgvdp.model import catalog


@pytest.fixture(scope="module")
def client():
    with served() as client:
        yield client


@pytest.fixture(scope="module")
def finished(client):
    run = wait_for(client, ask(client, **SHORT)["id"], "done", "failed")
    assert run["error"] is None
    return run["id"]


def test_a_run_from_the_question_to_the_profile(client, finished):
    view = client.get(f"/api/runs/{finished}/view").json()
    assert (view["kind"], view["name"]) == ("search", "tgv on flat-100km, to 3000.0, points 3")
    assert len(view["content"]["front"]) == 3
    assert all(point["replay"]["ok"] for point in view["content"]["front"])
    profile = client.get(f"/api/runs/{finished}/profiles/2").json()
    assert profile["position_m"][-1] == 3000.0
    assert profile["time_s"][-1] == pytest.approx(view["content"]["front"][2]["time_s"], rel=1e-6)
    assert len({len(column) for column in profile.values()}) == 1


@pytest.mark.parametrize(
    "path",
    [
        "/page/../limits.py",
        "/page/..%2f..%2flimits.py",
        "/page/%2e%2e/%2e%2e/etc/passwd",
        "/page//etc/passwd",
        "/page/vendor/uPlot.LICENSE",
        "/page/..\\limits.py",
        "/page/limits.py%00.js",
        "//etc/passwd",
        "/api/runs/..%2f..%2fetc/view",
        "/api/runs/1/profiles/..%2f0",
    ],
)
def test_no_path_reaches_the_file_system(client, finished, path):
    answer = client.get(path)
    assert answer.status_code == 404
    assert b"root:" not in answer.content
    assert b"class Limits" not in answer.content


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1.evil.example", "", "127.0.0.1@evil.example", "127.0.0.1:x"]
)
@pytest.mark.parametrize("path", ["/", "/page/main.js", "/api/runs"])
def test_forged_hosts_are_refused(client, host, path):
    assert client.get(path, headers={"host": host}).status_code == 400


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost:8765", "LOCALHOST", "[::1]:8765"])
def test_names_of_loopback_are_answered(client, host):
    assert client.get("/api/runs", headers={"host": host}).status_code == 200


def test_names_of_hosts():
    assert host_name("[::1]:80") == "::1"
    assert host_name("a/b") is None


@pytest.mark.parametrize("origin", [None, "null", "http://evil.example", "https://127.0.0.1", f"{HOST}:8080"])
@pytest.mark.parametrize(("method", "path"), [("POST", "/api/runs"), ("POST", "/api/uploads"), ("POST", "/api/drafts")])
def test_changes_come_from_the_page_itself(client, origin, method, path):
    headers = {} if origin is None else {"origin": origin}
    assert client.request(method, path, json=SHORT, headers=headers).status_code == 403


def test_dropping_a_run_needs_the_origin_too(client, finished):
    assert client.delete(f"/api/runs/{finished}").status_code == 403
    assert client.get(f"/api/runs/{finished}").status_code == 200


@pytest.mark.parametrize(
    ("method", "path"),
    [("PUT", "/api/runs"), ("DELETE", "/api/runs"), ("POST", "/"), ("PATCH", "/api/runs/1"), ("TRACE", "/")],
)
def test_other_methods_are_refused(client, method, path):
    assert client.request(method, path, headers=ORIGIN, content=b"").status_code == 405


def test_answers_are_strict(client, finished):
    for path in ("/", "/page/main.js", "/api/runs", "/api/nothing", f"/api/runs/{finished}/view"):
        headers = client.get(path).headers
        assert headers["content-security-policy"] == POLICY
        assert headers["x-content-type-options"] == "nosniff"
    assert "unsafe" not in POLICY


def test_the_page_has_no_inline_script_or_style_and_names_no_other_machine():
    page = assets()["index.html"].data.decode()
    assert all(part.startswith((' src="/page/', "</")) for part in page.split("<script")[1:]) or "<script>" not in page
    assert "style=" not in page
    assert "<style" not in page
    for name, asset in assets().items():
        text = asset.data.decode().replace("http://www.w3.org/", "")
        assert name == "uplot.min.js" or ("http://" not in text and "https://" not in text), name


def test_large_requests_are_refused_before_they_are_read():
    with served(upload_b=1000, request_b=100) as client:
        assert client.post("/api/uploads?name=a", content=b"x" * 1001, headers=ORIGIN).status_code == 413
        assert client.post("/api/runs", content=b" " * 101, headers=ORIGIN).status_code == 413
        assert client.post("/api/uploads?name=a", content=iter([b"x"] * 2000), headers=ORIGIN).status_code == 411


@pytest.mark.parametrize(
    ("asked", "field", "words"),
    [
        ({"train": "tgw"}, "train", "unknown train"),
        ({"train": "/etc/passwd"}, "train", "unknown train"),
        ({"track": "upload:7:0"}, "track", "no longer here"),
        ({"options": {"points": 1}}, "points", "must be at least 2, got 1"),
        ({"options": {"points": "many"}}, "points", "must be"),
        ({"options": {"points": [3]}}, "points", "must be"),
        ({"options": {"max_margin_pct": -5}}, "max_margin_pct", "must be above 0 %, got -5 %"),
        ({"options": {"wind_kmh": 600}}, "wind_kmh", "must be at most 500 km/h, got 600 km/h"),
        ({"options": {"points": 9, "method": "exact"}}, "points", "belongs to method front, it has no effect on exact"),
        ({"options": {"at": "5 apples"}}, "at", "must be a margin"),
        ({"options": {"at": "5%", "points": 9}}, "points", "has no effect beside"),
        ({"options": {"at": 7}}, "at", "value of another kind"),
        ({"options": {"at": "5%", "method": "exact"}}, "at", "belongs to method front, it has no effect on exact"),
        ({"options": {"speed_restriction": [1, 2]}}, "speed_restriction", "value of another kind"),
        ({"options": {"speeds": 9}}, "speeds", "belongs to method"),
        ({"options": {"energy": "/etc/passwd"}}, "energy", "must be one of"),
        ({"options": {"max_memory_mb": 9e9}}, "max_memory_mb", "no option"),
        ({"options": {"from_m": None}}, "from_m", "must be"),
        ({"limits_kmh": {"0].x=[": 5.0}}, "limits_kmh", "must be the index"),
        ({"mass_t": "x"}, "", "Expected"),
        ({"unknown": 1, "train": 5}, "", "Expected"),
    ],
)
def test_errors_name_their_field(client, asked, field, words):
    answer = client.post("/api/runs", json=asked, headers=ORIGIN)
    assert answer.status_code == 422
    assert answer.json()["field"] == field
    assert words in answer.json()["message"]
    assert "search:" not in answer.json()["message"]


@pytest.mark.parametrize(
    ("asked", "field"),
    [
        ({"mass_t": -1.0}, "mass_t"),
        ({"limits_kmh": {"99": 50.0}}, "limits_kmh"),
        ({"limits_kmh": {"0": 0.0}}, "limits_kmh"),
    ],
)
def test_errors_found_by_a_run_name_their_field(client, asked, field):
    run = wait_for(client, ask(client, **(SHORT | asked))["id"], "done", "failed")
    assert run["error"]["field"] == field


@pytest.mark.parametrize("data", ["{}", "[]", '{"asked": {}, "delay_s": "x"}', "[" * 40_000 + "]" * 40_000])
def test_a_draft_of_nothing_is_refused(client, data):
    headers = ORIGIN | {"content-type": "application/json"}
    answer = client.post("/api/drafts", content=data, headers=headers)
    assert answer.status_code == 422
    assert "must hold asked and delay_s" in answer.json()["message"]


def upload(client, name, data):
    return client.post("/api/uploads", params={"name": name}, content=data, headers=ORIGIN)


def test_an_uploaded_file_is_read_and_run(client):
    answer = upload(client, "../../mine.toml", catalog.path("alstom-emu", "train").read_bytes())
    assert answer.status_code == 201
    (held,) = answer.json()["holds"]
    assert (answer.json()["name"], held["kinds"]) == ("mine.toml", ["train"])
    asked = SHORT | {"train": f"upload:{answer.json()['id']}:0"}
    run = wait_for(client, ask(client, **asked)["id"], "done", "failed")
    assert run["name"] == "alstom-emu on flat-100km, to 3000.0, points 3"


@pytest.mark.parametrize("data", [b"", b"{", b"\x00\xff\xfe", b"PK\x03\x04 no archive", b"<a>" * 9, b"[" * 100_000])
def test_a_broken_file_is_an_error_and_is_not_kept(client, data):
    before = dict(client.explorer.uploads)
    answer = upload(client, "broken.json", data)
    assert answer.status_code == 422
    assert answer.json()["message"].startswith("broken.json: ")
    assert client.explorer.uploads == before


def test_an_uploaded_file_cannot_reach_the_file_system(client, tmp_path):
    secret = tmp_path / "secret.toml"
    secret.write_bytes(catalog.path("tgv", "train").read_bytes())
    answer = upload(client, "a.toml", f'train = "{secret}"\n'.encode())
    assert answer.status_code == 422
    assert "references another file" in answer.json()["message"]


def test_runs_queue_and_are_cancelled():
    with served(runs_at_once=1, runs_queued=2) as client:
        first, second, third = (ask(client, **asked)["id"] for asked in (ENDLESS, ENDLESS, SHORT))
        wait_for(client, first, "running")
        refused = client.post("/api/runs", json=SHORT, headers=ORIGIN)
        assert refused.status_code == 429
        assert [run["state"] for run in client.get("/api/runs").json()] == ["running", "queued", "queued"]
        assert client.delete(f"/api/runs/{second}", headers=ORIGIN).status_code == 204
        assert client.delete(f"/api/runs/{first}", headers=ORIGIN).status_code == 204
        wait_for(client, third, "done")
        assert client.get(f"/api/runs/{first}").status_code == 404
        assert client.delete(f"/api/runs/{first}", headers=ORIGIN).status_code == 404


def test_a_client_that_leaves_harms_nobody():
    """It hangs up in the middle of an upload, of a draft, and while its run goes on, which goes on."""
    with listening() as home:
        host, port = home.removeprefix("http://").split(":")
        head = f"Host: {host}:{port}\r\nOrigin: {home}\r\nContent-Type: application/json\r\n"
        body = json.dumps(SHORT)
        draft = json.dumps({"asked": SHORT, "delay_s": 5.0})
        for path, length, sent in (
            ("/api/uploads?name=a.json", 5000, "{"), ("/api/drafts", len(draft), draft), ("/api/runs", len(body), body),
        ):  # fmt: skip
            with socket.create_connection((host, int(port))) as connection:
                connection.sendall(f"POST {path} HTTP/1.1\r\n{head}Content-Length: {length}\r\n\r\n{sent}".encode())
                time.sleep(0.2)
        end = time.monotonic() + 300.0
        state = ""
        while state != "done" and time.monotonic() < end:
            time.sleep(0.1)
            with urllib.request.urlopen(f"{home}/api/runs") as answer:
                state = json.load(answer)[0]["state"]
        assert state == "done"


def test_a_run_tells_how_far_it_is():
    with served() as client:
        run = ask(client, **ENDLESS)["id"]
        end = time.monotonic() + 120.0
        while time.monotonic() < end:
            progress = client.get(f"/api/runs/{run}").json()["progress"]
            if progress.get("counters", {}).get("expanded", 0) > 0:
                break
            time.sleep(0.05)
        assert progress["stage"] == "searching"
        assert client.get(f"/api/runs/{run}/view").status_code == 409


def test_a_crashed_process_is_an_error_and_another_takes_its_place():
    with served(runs_at_once=1) as client:
        run = ask(client, **ENDLESS)["id"]
        wait_for(client, run, "running")
        time.sleep(0.5)
        for number in client.explorer.processes.alive:
            os.kill(number, 9)
        assert "has ended" in wait_for(client, run, "failed")["error"]["message"]
        assert wait_for(client, ask(client, **SHORT)["id"], "done", "failed")["state"] == "done"


def test_time_ends_a_run():
    with served(running_s=3.0) as client:
        error = wait_for(client, ask(client, **ENDLESS)["id"], "failed")["error"]
        assert "longer than 3 s" in error["message"]


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="only some systems limit the memory of a process")
def test_memory_ends_a_run():
    with served(memory_b=7e8) as client:  # libraries and kernels take 0.5 GB of that
        error = wait_for(client, ask(client, **ENDLESS)["id"], "failed", "done")["error"]
        assert "memory" in error["message"]


def test_old_runs_go_and_old_files_too():
    with served(runs_kept=1, uploads=1, runs_at_once=1) as client:
        ids = []
        for _ in range(3):
            ids.append(ask(client, **SHORT)["id"])
            wait_for(client, ids[-1], "done")
        kept = [run["id"] for run in client.get("/api/runs").json()]
        assert ids[0] not in kept
        assert ids[-1] in kept
        data = catalog.path("tgv", "train").read_bytes()
        first = upload(client, "a.toml", data).json()["id"]
        upload(client, "b.toml", data)
        assert list(client.explorer.uploads) != [first]
        assert len(client.explorer.uploads) == 1


def test_a_draft_answers_at_once_what_a_run_answers(client, finished):
    asked = SHORT | {"mass_t": 500.0}
    answer = client.post("/api/drafts", json={"asked": asked, "delay_s": 20.0}, headers=ORIGIN)
    draft = answer.json()["content"]
    run = wait_for(client, ask(client, **asked)["id"], "done")
    view = client.get(f"/api/runs/{run['id']}/view").json()
    assert draft["energy_kwh"] == pytest.approx([point["energy_kwh"] for point in view["content"]["front"]], rel=1e-9)
    assert view["editable"]["mass_now_t"] == 500.0
    light = client.get(f"/api/runs/{finished}/view").json()
    assert draft["fastest"]["energy_kwh"] > light["content"]["fastest"]["energy_kwh"]


def test_nothing_is_written(client, finished, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with served() as other:
        wait_for(other, ask(other, **SHORT)["id"], "done")
    assert list(tmp_path.iterdir()) == []
