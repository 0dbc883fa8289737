"""What if: an edit changes what the picture shows at its place, whatever part and direction of the line that is."""

import json
import urllib.request
from dataclasses import replace

import pytest

from tests.helpers.browser_case import await_address, figure, listening, open_page
from tests.helpers.report_case import railway_trip
from tgvdp.explorer.compute.editable import editable_of
from tgvdp.model.variants import reversed_track

sync_api = pytest.importorskip("playwright.sync_api", reason="the tests of the page need playwright")
MINUTE_MS = 60_000
#: The last 20 km of the line, from its end: 160 km/h, 230 from km 2.5, 300 from km 6.5.
BACK = {
    "track": "lgv-100km",
    "options": {"reverse": True, "to_m": 20_000.0, "points": 8, "speed_restriction": ["10km:14km:80"]},
}


def place(page, share, kmh, ceiling_kmh):
    """Where a speed is drawn, at a share of the distance."""
    box = page.locator(".profile .u-over").first.bounding_box()
    return box["x"] + share * box["width"], box["y"] + box["height"] * (1.0 - kmh / (1.06 * ceiling_kmh))


def cursor(page, *at):
    page.mouse.move(*place(page, *at))
    return page.locator(".profile .u-over").first.evaluate("over => over.style.cursor")


def limits_kmh(home, run):
    with urllib.request.urlopen(f"{home}/api/runs/{run}/view") as answer:
        limits = json.load(answer)["content"]["line"]["limits"]
    return [(row["from_m"], round(3.6 * row["speed_mps"], 6)) for row in limits]


def test_limits_are_where_the_trip_meets_them():
    trip = railway_trip()  # from 1 to 5 km of 6
    limits = editable_of(trip, trip.track, 5e5, reverse=False)["limits"]
    assert [(row["row"], row["from_m"], row["to_m"]) for row in limits] == [
        (0, 1000.0, 2000.0), (1, 2000.0, 4500.0), (2, 4500.0, 5000.0),
    ]  # fmt: skip
    back = replace(trip, track=reversed_track(trip.track))
    found = editable_of(back, trip.track, 5e5, reverse=True)
    assert [(row["row"], row["from_m"], row["to_m"]) for row in found["limits"]] == [
        (2, 1000.0, 1500.0), (1, 1500.0, 4000.0), (0, 4000.0, 5000.0),
    ]  # fmt: skip
    assert (found["mass_t"], found["mass_now_t"], found["top_kmh"]) == (500.0, 400.0, 144.0)


def test_the_limit_that_is_dragged_is_the_one_under_the_pointer(watched):
    with listening(asked=BACK) as home:
        page = open_page(watched, home)
        assert limits_kmh(home, 1)[:3] == [(0.0, 160.0), (2500.0, 230.0), (6500.0, 300.0)]
        assert cursor(page, 0.9, 300.0, 300.0) == "ns-resize"
        assert cursor(page, 0.6, 80.0, 300.0) == ""  # a speed restriction is an option of the run
        assert cursor(page, 0.6, 300.0, 300.0) == ""
        page.mouse.move(*place(page, 0.05, 160.0, 300.0))
        page.mouse.down()
        page.mouse.move(*place(page, 0.05, 120.0, 300.0), steps=3)
        page.mouse.move(*place(page, 0.05, 100.0, 300.0), steps=3)
        page.mouse.up()
        sync_api.expect(page.locator("#draft-status")).to_contain_text("s more and", timeout=MINUTE_MS)
        page.get_by_text("Speed limits in km/h").click()
        assert page.get_by_label("Limit from km 0, km/h").input_value() == "100"
        page.get_by_label("Limit from km 2.5, km/h").fill("200")
        page.get_by_role("button", name="Keep as a run").click()
        sync_api.expect(page.locator("#title")).to_contain_text("2 limits changed", timeout=5 * MINUTE_MS)
        assert limits_kmh(home, 2)[:3] == [(0.0, 100.0), (2500.0, 200.0), (6500.0, 300.0)]
        watched.require_clean(home)


def test_a_limit_above_the_top_speed_is_taken_where_it_is_drawn(watched):
    options = {"from_m": 20_000.0, "to_m": 40_000.0, "points": 8}
    with listening(asked={"train": "alstom-emu", "track": "lgv-100km", "options": options}) as home:
        page = open_page(watched, home)
        assert cursor(page, 0.5, 220.0, 220.0) == "ns-resize"
        assert cursor(page, 0.5, 170.0, 220.0) == ""
        watched.require_clean(home)


def test_the_edited_run_is_that_of_the_chosen_delay(watched):
    with listening(asked={"track": "flat-100km", "options": {"to_m": 20_000.0, "points": 8}}) as home:
        page = open_page(watched, f"{home}/#point=1&show=time")
        drafts = []
        page.on("request", lambda request: drafts.append(request.post_data) if "/api/drafts" in request.url else None)
        page.locator("#mass").press("End")
        sync_api.expect(page.locator("#draft-status")).to_contain_text("the fastest run takes", timeout=MINUTE_MS)
        page.locator("#delay").press("End")
        await_address(page, "point=7")
        with page.expect_response("**/api/drafts"):
            page.locator("#delay").press("ArrowLeft")
        assert figure(page, "Delay")
        wanted_s = [json.loads(draft)["delay_s"] for draft in drafts]
        assert wanted_s[0] < 0.5 * wanted_s[-1]
        watched.require_clean(home)
