"""Journeys and benchmarks have their pages."""

import json

import pytest

from tests.helpers.browser_case import ARGUMENTS, Watched, await_address, example_exhibit, executable, figure, listening
from tgvdp.explorer.folder import read_folder

sync_api = pytest.importorskip("playwright.sync_api", reason="the tests of the page need playwright")
JOURNEY = {
    "schema": "tgvdp.journey/1",
    "sections": [
        {"from_m": 0.0, "to_m": 2000.0, "fastest_time_s": 100.0},
        {"from_m": 2000.0, "to_m": 5000.0, "fastest_time_s": 150.0},
    ],
    "fastest": {"time_s": 250.0, "energy_kwh": 40.0},
    "front": [
        {
            "time_s": 250.0 + 2 * part,
            "energy_kwh": 30.0 - part,
            "price_kwh_per_min": 30.0 / (1 + part),
            "lower_bound_kwh": 29.9 - part,
            "gap_pct": 10.0 / (30.0 - part),
            "sections": [
                {"time_s": 100.0 + part, "energy_kwh": 12.0 - 0.5 * part},
                {"time_s": 150.0 + part, "energy_kwh": 18.0 - 0.5 * part},
            ],
            "waiting": {"time_s": 13.0 * part, "energy_kwh": 0.1 * part},
        }
        for part in range(6)
    ],
    "practices": {
        "all_at_the_end": [{"time_s": 250.0 + 2 * part, "energy_kwh": 30.0 - 0.5 * part} for part in range(6)],
        "linear_margin": [
            {"time_s": 250.0 + 2 * part, "energy_kwh": 31.0 - 0.5 * part if part else None} for part in range(6)
        ],
    },
    "complete": True,
}
ENSEMBLES = """family,N,solver,instances,solved,p median,p least,p most,TTS99 s,TTS99 s low,TTS99 s high
easy,4,dp,3,3,1,1,1,0.001,0.001,0.002
easy,8,dp,3,3,1,1,1,0.002,0.001,0.003
easy,4,sa:unary,3,3,0.75,0.5,1,0.01,0.005,0.02
easy,8,sa:unary,3,2,0.25,0,0.5,inf,0.01,inf
"""
SIZES = """Problem,N,encoding,# Decision Variables,# Non-Zero Coefficients
a,4,unary,8,20
a,8,unary,16,60
"""


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    journey, bench = (tmp_path_factory.mktemp(name) for name in ("journey", "bench"))
    (journey / "journey.json").write_text(json.dumps(JOURNEY))
    (bench / "benchmark.json").write_text('{"schema": "tgvdp.bench/2"}')
    (bench / "ensembles.csv").write_text(ENSEMBLES)
    (bench / "benchmark.csv").write_text(SIZES)
    with listening([read_folder(str(journey)), read_folder(str(bench)), example_exhibit()]) as home:
        yield home


@pytest.fixture(scope="module")
def watched():
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable(), args=ARGUMENTS)
        yield Watched(browser.new_page())
        browser.close()


def test_a_journey_shows_how_its_supplement_is_split(watched, home):
    page = watched.page
    page.goto(f"{home}/#run=folder-1&point=5")
    page.wait_for_selector("#figures dl")
    rows = page.get_by_role("region", name="Sections").locator("tbody tr")
    assert rows.count() == 2
    assert "5.0" in rows.nth(0).inner_text()  # 5 s of 100 s
    assert figure(page, "all before the last stop") == "27.50 kWh"
    assert figure(page, "all speeds scaled") == "28.50 kWh"
    assert figure(page, "Waiting") == "1:05 min, 0.500 kWh"
    assert figure(page, "Proven within") == "0.40 %"
    page.locator("#delay").press("Home")
    await_address(page, "point=0")
    assert "0.0" in rows.nth(0).inner_text()
    for name in ("all speeds scaled", "Waiting"):  # there is none in the time of that point
        assert name not in page.locator("#figures").inner_text()
    watched.require_clean(home)


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_lines_of_a_journey_are_told_apart_by_colour(watched, home, theme):
    page = watched.page
    page.goto(f"{home}/#run=folder-1&theme={theme}")
    page.reload()
    swatches = page.locator(".legend .swatch")
    swatches.first.wait_for()
    colors = swatches.evaluate_all("all => all.map((one) => getComputedStyle(one).backgroundColor)")
    assert len(set(colors)) == len(colors) == 1 + len(JOURNEY["practices"])
    watched.require_clean(home)


@pytest.mark.parametrize("shown", ["folder-1", "folder-2", "folder-3"])
def test_the_shown_one_is_marked_and_only_searches_are_laid_over_searches(watched, home, shown):
    page = watched.page
    page.goto(f"{home}/#run={shown}")
    page.reload()
    page.locator(f'[data-run={shown}] [aria-pressed="true"]').wait_for()
    laid_over = page.locator(".over").evaluate_all("all => all.map((one) => one.closest('li').dataset.run)")
    assert laid_over == (["folder-3"] if shown == "folder-3" else [])
    watched.require_clean(home)


def test_a_benchmark_shows_success_and_size_against_n(watched, home):
    page = watched.page
    page.goto(f"{home}/#run=folder-2")
    page.reload()
    page.wait_for_selector(".benchmark .chart")
    assert "sa:unary" in page.locator(".legend").first.inner_text()
    assert "variables, unary" in page.locator(".benchmark").inner_text()
    marked = page.evaluate(
        "import('/page/benchmark.js').then((page) => [page.decades(0.5, 1.3), page.decades(0.5, 4.2)])"
    )
    assert [[round(10**at) for at in marks] for marks in marked] == [[5, 10], [10, 100, 1000, 10_000]]
    last = page.get_by_role("region", name="Medians").locator("tbody tr").last.inner_text().split()
    assert last == ["sa:unary", "8", "3", "2", "0.250", "–"]
    watched.require_clean(home)
