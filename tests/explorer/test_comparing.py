"""Runs side by side: only what compares is compared, and what a result lacks is not shown as nothing."""

import json
from dataclasses import replace

import pytest

from tests.helpers.browser_case import await_address, example_exhibit, figure, listening, open_page
from tests.helpers.report_case import PROVENANCE, VERDICT, make_result, railway_trip
from tgvdp.explorer.exhibit import profiles_of, search_exhibit
from tgvdp.model.variants import reversed_track
from tgvdp.report.tables import result_object

sync_api = pytest.importorskip("playwright.sync_api", reason="the tests of the page need playwright")
SPEEDS = (38.0, 33.0, 29.0, 26.0, 23.0)
#: Begins a function of the page that has a profile of nine metres, the last four of them downhill.
PROFILE = """async () => {
    const { Profile } = await import("/page/profile.js");
    const limits = [0, 9].map((from_m) => ({ from_m, speed_mps: 9 }));
    const altitude = [[0, 1], [4, 1], [5, 1], [9, 0]].map(([position_m, altitude_m]) => ({ position_m, altitude_m }));
    const content = { trip: { origin_m: 0, destination_m: 9 }, line: { limits, altitude, features: {} } };
    const profile = new Profile(content, ["traction"]);
    return """


def content_of(trip):
    result = make_result(trip, list(SPEEDS))
    return json.loads(json.dumps(result_object(result, [VERDICT] * len(SPEEDS), PROVENANCE))), profiles_of(result)


def other_direction():
    trip = railway_trip()
    content, profiles = content_of(replace(trip, track=reversed_track(trip.track)))
    return search_exhibit("back", content, profiles)


def at_the_pantograph():
    """The same runs as the example, with twice the energy, counted elsewhere."""
    content, profiles = content_of(railway_trip())
    content["energy"] = {"model": "pantograph"}
    for run in (content["fastest"], *content["front"]):
        run["energy_kwh"] *= 2.0
    return search_exhibit("drawn", content, profiles)


def ended_early():
    """Written within a time limit: no figures of the rows, and profiles of the first and the last point."""
    content, profiles = content_of(railway_trip())
    for run in (content["fastest"], *content["front"]):
        run |= {"peak_power_kw": None, "balance": dict.fromkeys(run["balance"]), "ride": dict.fromkeys(run["ride"])}
    return search_exhibit("ended", content, {name: profiles[name] for name in ("fastest", "0", "4")})


@pytest.fixture(scope="module")
def home():
    with listening([example_exhibit(), other_direction(), at_the_pantograph(), ended_early()]) as home:
        yield home


def test_the_other_direction_is_another_line(watched, home):
    page = open_page(watched, f"{home}/#a=folder-1:1&b=folder-2:1")
    page.wait_for_selector("#compare")
    assert "different lines" in page.locator("#compare").inner_text()
    assert page.locator(".profile .chart").count() == 2
    watched.require_clean(home)


def test_energies_of_different_places_are_not_subtracted(watched, home):
    page = open_page(watched, f"{home}/#a=folder-1:1&b=folder-3:1")
    page.wait_for_selector("#compare")
    rows = {row.split("\t")[0]: row.split("\t")[1:] for row in page.locator("#compare tbody").inner_text().splitlines()}
    assert rows["Energy"][-1] == "–"
    assert rows["At the pantograph"][-1].startswith("0 ")
    assert "A counts wheel, B pantograph" in page.locator("#compare").inner_text()
    assert "Half of the difference in energy" not in page.locator("#compare").inner_text()
    assert page.locator(".profile .chart").count() == 3  # speed, the difference in time, the line
    watched.require_clean(home)


def test_overlays_are_named_and_hold_the_same_energy(watched, home):
    page = open_page(watched, f"{home}/#over=folder-2,folder-3")
    sync_api.expect(page.locator("#over .key")).to_have_text(["back"])
    assert "drawn (pantograph)" in page.locator("#over").inner_text()
    watched.require_clean(home)


def test_what_a_search_had_no_time_for_is_not_shown_as_nothing(watched, home):
    page = open_page(watched, f"{home}/#run=folder-4")
    sync_api.expect(page.locator("#title")).to_have_text("ended")
    await_address(page, "run=folder-4")
    assert figure(page, "Delay").startswith("0 s")  # the point with a profile that is nearest to the middle
    names = ["Delay", "Running time", "Energy", "Saved", "Replayed"]
    assert page.locator("#figures dt").all_inner_texts() == names
    page.locator("#delay").press("ArrowRight")
    await_address(page, "point=1")
    assert figure(page, "Delay").startswith("+")
    sync_api.expect(page.locator("#unwritten")).to_be_visible()
    assert page.locator(".profile .chart").first.is_hidden()
    page.locator("#delay").press("End")
    sync_api.expect(page.locator("#unwritten")).to_be_hidden()
    sync_api.expect(page.locator(".profile .chart").first).to_be_visible()
    watched.require_clean(home)


def test_of_two_runs_that_are_asked_for_the_last_one_is_shown(watched, home):
    page, held = open_page(watched, home), []

    def hold(route):
        held.append(route)

    page.route("**/folder-2/view", hold)
    page.get_by_role("button", name="back", exact=True).click()
    page.get_by_role("button", name="ended", exact=True).click()
    sync_api.expect(page.locator("#title")).to_have_text("ended")
    with page.expect_response("**/folder-2/view"):
        held[0].continue_()
    page.locator("#delay").press("End")
    await_address(page, "point=4")
    assert "run=folder-4" in page.url
    assert page.locator("#title").inner_text() == "ended"
    watched.require_clean(home)


def test_the_name_of_a_forgotten_run_goes(watched):
    with listening([example_exhibit()]) as home:
        page = open_page(watched, home)
        page.get_by_role("button", name="Forget example").click()
        sync_api.expect(page.locator("#status")).to_contain_text("No run yet")
        assert page.locator("#title").inner_text() == ""
        watched.require_clean(home)


def test_the_gradient_at_the_end_is_the_last_one(watched, home):
    page = open_page(watched, home)
    gradients = page.evaluate(f"{PROFILE} [0, 4, 5, 9].map((at_m) => profile.gradient(at_m)); }}")
    assert gradients == [0.0, 0.0, -250.0, -250.0]
    watched.require_clean(home)


def test_an_effort_and_its_power_end_where_its_row_does(watched, home):
    """Cruising for a kilometre, then coasting: the power does not fall along the way."""
    page = open_page(watched, home)
    course = page.evaluate(
        """async () => (await import("/page/course.js")).courseOf({
            position_m: [0, 1000, 2000], speed_mps: [20, 20, 19], time_s: [0, 50, 101], energy_j: [0, 5e6, 5e6],
            force_n: [5000, 0, 0], regime: [1, 2, 2],
        })"""
    )
    assert (course["P"][0], course["beforeNext"][0], course["P"][1]) == (1e5, 1e5, 0.0)
    watched.require_clean(home)


def test_the_unit_of_a_panel_is_that_of_its_values(watched, home):
    page = open_page(watched, home)
    labels = page.evaluate(
        f"""{PROFILE} [2e6, 3e5].map((power_w) => {{
            const course = {{ x: [0, 9], v: [9, 9], t: [0, 1], E: [0, 9], F: [0, 0], regime: [0, 0] }};
            Object.assign(course, {{ P: [power_w, power_w], beforeNext: [power_w, power_w] }});
            profile.show([{{ course }}], ["power"]);
            return [profile.charts.power.look.yLabel, profile.panelScale("power").unit];
        }}); }}"""
    )
    assert labels == [["Power (MW)", "MW"], ["Power (kW)", "kW"]]
    watched.require_clean(home)
