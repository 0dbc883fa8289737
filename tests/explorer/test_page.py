"""The page in a headless browser, as a person uses it: no console error, and no request that leaves the machine."""

import json
import re

import pytest

from tests.helpers.browser_case import (
    Watched,
    await_address,
    example_exhibit,
    figure,
    large_exhibit,
    listening,
    open_page,
)
from tests.helpers.format_case import TTOBENCH_TRACK, TTOBENCH_TRAIN
from tests.helpers.report_case import PROVENANCE
from tgvdp.report.palette import DARK, LIGHT

sync_api = pytest.importorskip("playwright.sync_api", reason="the tests of the page need playwright")
MINUTE_MS = 60_000


@pytest.fixture(scope="module")
def home():
    """A server with two exhibits that were there before."""
    with listening([example_exhibit(), example_exhibit("slow", (30.0, 26.0, 22.0))]) as home:
        yield home


def click_point(page, delay_share):
    """Click on the front where its delay is a share of the largest."""
    page.locator(".front .u-over").scroll_into_view_if_needed()
    box = page.locator(".front .u-over").bounding_box()
    page.mouse.click(box["x"] + box["width"] * (0.04 + 0.92 * delay_share), box["y"] + 0.4 * box["height"])


def test_a_click_chooses_a_profile(watched, home):
    page = open_page(watched, home)
    click_point(page, 0.0)
    await_address(page, "point=0")
    first = figure(page, "Running time")
    click_point(page, 1.0)
    await_address(page, "point=4")
    assert figure(page, "Running time") != first
    assert page.locator("#delay").get_attribute("aria-valuetext").startswith(figure(page, "Delay").split(" (")[0])
    watched.require_clean(home)


def test_dragging_along_the_front_goes_from_profile_to_profile(watched, home):
    page = open_page(watched, home)
    box = page.locator(".front .u-over").bounding_box()
    middle = box["y"] + 0.5 * box["height"]
    page.mouse.move(box["x"] + 0.05 * box["width"], middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.5 * box["width"], middle, steps=4)
    page.mouse.move(box["x"] + 0.97 * box["width"], middle, steps=4)
    page.mouse.up()
    await_address(page, "point=4")
    watched.require_clean(home)


def test_the_slider_and_the_keyboard_do_the_same(watched, home):
    page = open_page(watched, f"{home}/#point=1")
    page.locator("#delay").focus()
    before = figure(page, "Delay")
    page.keyboard.press("ArrowRight")
    await_address(page, "point=2")
    assert figure(page, "Delay") != before
    page.keyboard.press("End")
    await_address(page, "point=4")
    page.locator("#delay").fill("0")
    await_address(page, "point=0")
    watched.require_clean(home)


def test_two_pins_are_compared_and_the_url_holds_all(watched, home):
    page = open_page(watched, f"{home}/#point=1")
    page.get_by_role("button", name="Pin as A").click()
    page.locator("#delay").press("End")
    page.get_by_role("button", name="Pin as B").click()
    page.get_by_label("Energy used").check()
    await_address(page, "show=energy")
    table = page.locator("#compare table").inner_text()
    assert re.search(r"B − A\b", table)
    assert re.search(r"Energy\b.*−", table)
    assert "Half of the difference in energy arises between" in page.locator("#compare").inner_text()
    assert page.locator(".profile .chart").count() == 5  # speed, energy, two differences, the line
    other = watched.page.context.new_page()
    other.goto(page.url)
    other.wait_for_selector("#compare")
    assert other.locator("#compare table").inner_text() == table
    page.get_by_role("button", name="Unpin A").click()
    page.wait_for_selector("#compare", state="detached")
    watched.require_clean(home)


def test_another_run_is_laid_over(watched, home):
    page = open_page(watched, home)
    page.locator("[data-run='folder-2'] input").check()
    await_address(page, "over=folder-2")
    page.get_by_role("button", name="slow", exact=True).click()
    sync_api.expect(page.locator("#title")).to_have_text("slow")
    watched.require_clean(home)


def choose_files(page, *files):
    page.get_by_role("button", name="New run").click()
    page.locator("#file").set_input_files([{"name": name, "mimeType": "", "buffer": data} for name, data in files])


def test_a_pair_of_ttobench_files_is_uploaded_and_run(watched, home):
    page = open_page(watched, home)
    pair = [("train.json", TTOBENCH_TRAIN), ("line.json", TTOBENCH_TRACK)]
    choose_files(page, *((name, json.dumps(tree).encode()) for name, tree in pair))
    sync_api.expect(page.locator(".taken")).to_contain_text("track", timeout=MINUTE_MS)
    assert "(TTOBench)" in page.locator(".taken li").first.inner_text()
    page.locator("#field-points").fill("5")
    page.get_by_role("button", name="Run", exact=True).click()
    name = page.locator("#title")
    sync_api.expect(name).to_have_text("toy on toy, points 5", timeout=5 * MINUTE_MS)
    assert page.locator("details table tbody tr").count() >= 5
    watched.require_clean(home)


def test_a_broken_file_shows_its_error(watched, home):
    page = open_page(watched, home)
    choose_files(page, ("broken.json", json.dumps(TTOBENCH_TRAIN | {"mass": {"unit": "t", "value": -3}}).encode()))
    error = page.locator(".taken .error")
    sync_api.expect(error).to_contain_text("broken.json: ", timeout=MINUTE_MS)
    assert "mass" in error.inner_text()
    watched.require_clean(home, allowed=["422"])


def test_an_error_stands_next_to_its_field(watched, home):
    page = open_page(watched, home)
    page.get_by_role("button", name="New run").click()
    page.locator("#field-max_margin_pct").fill("-5")
    page.get_by_role("button", name="Run", exact=True).click()
    sync_api.expect(page.locator("#error-max_margin_pct")).to_contain_text("must be above 0")
    assert page.locator("#field-max_margin_pct").get_attribute("aria-invalid") == "true"
    assert page.evaluate("document.activeElement.id") == "field-max_margin_pct"
    watched.require_clean(home, allowed=["422"])


def test_the_form_offers_what_the_method_has(watched, home):
    page = open_page(watched, home)
    page.get_by_role("button", name="New run").click()
    assert page.locator("#field-heuristic").is_hidden()
    assert page.get_by_text("Search on a grid").is_hidden()  # nothing would stand under it
    page.locator("#field-method").select_option("best-first")
    page.get_by_text("Search on a grid").click()
    assert page.locator("#field-heuristic").is_visible()
    assert page.locator("#field-points").is_hidden()
    watched.require_clean(home)


def test_what_was_read_is_named_with_the_first_digits_of_its_fingerprint(watched, home):
    """It was a line of JSON that ran out of its table."""
    page = open_page(watched, home)
    page.get_by_text("Where this comes from").click()
    inputs = page.get_by_role("table", name="Inputs")
    for role, read in PROVENANCE["inputs"].items():
        row = inputs.get_by_role("row", name=role)
        sync_api.expect(row).to_contain_text(f"{read.get('file', read.get('name'))}, sha256 {read['sha256'][:12]}…")
    assert "{" not in inputs.inner_text()
    sync_api.expect(page.get_by_text("a note", exact=True)).to_be_visible()
    watched.require_clean(home)


def test_a_limit_and_the_mass_are_dragged_and_the_front_is_solved_anew(watched):
    asked = {"track": "flat-100km", "options": {"to_m": 20_000.0, "points": 8}}
    with listening(asked=asked) as home:
        page = open_page(watched, home)
        status = page.locator("#draft-status")
        box = page.locator(".profile .u-over").first.bounding_box()
        top_kmh = 1.06 * 300
        x, y = box["x"] + 0.5 * box["width"], box["y"] + box["height"] * (1.0 - 300 / top_kmh)
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x, y + 0.2 * box["height"], steps=3)
        page.mouse.move(x, y + 0.4 * box["height"], steps=3)
        page.mouse.up()
        sync_api.expect(status).to_contain_text("s more and", timeout=MINUTE_MS)
        slower = status.inner_text()
        page.locator("#mass").press("End")
        sync_api.expect(status).not_to_have_text(slower, timeout=MINUTE_MS)
        page.get_by_role("button", name="Keep as a run").click()
        sync_api.expect(page.locator("#title")).to_contain_text("1 limits changed", timeout=5 * MINUTE_MS)
        assert page.locator(".runs li").count() == 2
        watched.require_clean(home)


def test_a_run_is_cancelled(watched, home):
    page = open_page(watched, home)
    page.get_by_role("button", name="New run").click()
    page.locator("#field-method").select_option("best-first")
    page.get_by_text("Search on a grid").click()
    for name in ("dominance", "bounds"):
        page.locator(f"#field-{name}").select_option("false")
    page.get_by_role("button", name="Run", exact=True).click()
    counters = page.locator("[data-state='running'] .counters")
    sync_api.expect(counters).to_contain_text("expanded", timeout=5 * MINUTE_MS)
    page.get_by_role("button", name=re.compile("^Cancel")).click()
    sync_api.expect(page.locator("[data-state='running']")).to_have_count(0)
    sync_api.expect(page).not_to_have_url(re.compile("awaits"))
    watched.require_clean(home)


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1300, 360])
def test_nothing_is_hard_to_perceive_or_to_reach(browser, home, scheme, width):
    """axe-core finds no serious violation, in either theme, on a desk and on a phone; nothing is wider than those."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-core is not installed").Axe()
    context = browser.new_context(viewport={"width": width, "height": 800}, color_scheme=scheme, bypass_csp=True)
    watched = Watched(context.new_page())
    page = open_page(watched, f"{home}/#a=folder-1:1&b=folder-1:3&show=force,power,energy,time")
    page.wait_for_selector("#compare")
    for summary in page.locator("main summary").all():
        summary.click()
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    found = [serious(axe.run(page))]
    page.get_by_role("button", name="New run").click()
    found.append(serious(axe.run(page)))
    context.close()
    assert found == [[], []]


def serious(results):
    return [
        (one["id"], one["nodes"][0]["html"][:120])
        for one in results.response["violations"]
        if one["impact"] in ("serious", "critical")
    ]


def test_the_theme_turns(watched, home):
    page = open_page(watched, home)
    paper = "getComputedStyle(document.documentElement).getPropertyValue('--paper').trim()"
    assert page.evaluate(paper) == LIGHT["paper"]
    page.locator("#theme").click()
    assert page.evaluate(paper) == DARK["paper"]
    assert "theme=dark" in page.url


def test_speed_is_measured(watched):
    """Prints, and asserts nothing about, durations (figures: 1.5 s and 0.2 s with 200 points × 2,000 rows)."""
    with listening([large_exhibit()]) as home:
        page = open_page(watched, home)
        shown_ms = page.evaluate("performance.now()")
        clicks_ms = page.evaluate(
            """async () => {
                const found = [];
                for (const point of [20, 180, 60, 140, 5]) {
                    const before = performance.now();
                    location.hash = `point=${point}`;
                    const slider = document.getElementById("delay");
                    const value = slider.value;
                    for (let i = 0; slider.value === value && i < 600; i += 1) await new Promise(requestAnimationFrame);
                    found.push(performance.now() - before);
                }
                return found;
            }"""
        )
        assert len(clicks_ms) == 5
        print(f"first picture {shown_ms:.0f} ms, click to profile {sorted(clicks_ms)[2]:.0f} ms (median)")
        watched.require_clean(home)


def test_the_search_is_played_step_by_step(watched):
    options = {"method": "best-first", "to_m": 10_000.0, "segment_m": 2500.0, "speeds": 8, "paths": 3}
    with listening(asked={"track": "flat-100km", "options": options}) as home:
        page = open_page(watched, home)
        told = page.locator("#step-told")
        assert told.inner_text().startswith("Before the first step")
        page.locator("#step").press("ArrowRight")
        assert told.inner_text().startswith("Step 1: label 0 is expanded")
        page.get_by_role("button", name="Play").click()
        sync_api.expect(told).to_have_text(re.compile(r"^Step (?!1:)\d"), timeout=MINUTE_MS)
        page.locator("#step").press("End")
        assert "a path" in told.inner_text()
        assert "Effective branching factor" in page.locator("#trace").inner_text()
        watched.require_clean(home)
