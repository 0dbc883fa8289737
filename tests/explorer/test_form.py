"""The form of a run asks for what it shows."""

import json

import pytest

from tests.helpers.browser_case import ARGUMENTS, Watched, executable, listening
from tgvdp.model import catalog

sync_api = pytest.importorskip("playwright.sync_api", reason="the tests of the page need playwright")
MINUTE_MS = 60_000


@pytest.fixture(scope="module")
def home():
    with listening() as home:
        yield home


@pytest.fixture
def watched():
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable(), args=ARGUMENTS)
        watched = Watched(browser.new_page())
        yield watched
        browser.close()


@pytest.fixture
def form(watched, home):
    """The page with its form open; runs that it asks for are written down and not begun."""
    page = watched.page
    page.asked = []

    def refuse(route):
        if route.request.method == "POST":
            page.asked.append(json.loads(route.request.post_data))
            route.fulfill(status=422, json={"message": "not now", "field": ""})
        else:
            route.continue_()

    page.route("**/api/runs", refuse)
    page.goto(home)
    page.get_by_role("button", name="New run").click()
    page.locator("#field-points").wait_for()
    return page


def run(form):
    form.get_by_role("button", name="Run", exact=True).click()
    sync_api.expect(form.locator("#error-")).to_have_text("not now")
    return form.asked[-1]


def scenario(options):
    """Bytes of a file with a map of its own and some options."""
    text = catalog.path("alstom-map", "map").read_text().replace('name = "alstom-map"', 'name = "own"')
    return f"run = {{ {options} }}\n{text}".encode()


def choose_file(form, name, data):
    form.locator("#file").set_input_files([{"name": name, "mimeType": "", "buffer": data}])


def test_the_map_of_a_scenario_is_its_own(form):
    choose_file(form, "own.toml", scenario('energy = "map", points = 7'))
    sync_api.expect(form.locator(".taken")).to_contain_text("map own", timeout=MINUTE_MS)
    options = run(form)["options"]
    assert options["points"] == 7
    assert options["energy"].startswith("upload:")


def test_a_field_that_was_emptied_is_as_usual(form):
    form.locator("#field-min_phase_s").fill("")
    form.locator("#field-points").fill("9")
    assert run(form)["options"] == {"points": 9}


def test_no_run_begins_while_a_file_is_read(form):
    submit = form.get_by_role("button", name="Run", exact=True)
    held = []

    def hold(route):
        held.append(route)

    form.route("**/api/uploads*", hold)
    choose_file(form, "own.toml", scenario("points = 7"))
    sync_api.expect(submit).to_be_disabled()
    held[0].continue_()
    sync_api.expect(submit).to_be_enabled(timeout=MINUTE_MS)
    assert run(form)["options"]["points"] == 7


def test_what_is_no_number_is_said(form):
    field = form.locator("#field-points")
    field.fill("")
    field.press_sequentially("1e")
    form.get_by_role("button", name="Run", exact=True).click()
    sync_api.expect(form.locator("#error-points")).to_have_text("must be a number")
    assert form.asked == []
