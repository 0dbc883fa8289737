"""A headless browser for the tests of a module, and a page of its own for each test."""

import pytest

from tests.helpers.browser_case import ARGUMENTS, Watched, executable


@pytest.fixture(scope="module")
def browser():
    sync_api = pytest.importorskip("playwright.sync_api", reason="the tests of the page need playwright")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable(), args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture
def watched(browser):
    context = browser.new_context(viewport={"width": 1300, "height": 950}, color_scheme="light")
    yield Watched(context.new_page())
    context.close()
