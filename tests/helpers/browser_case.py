"""A headless Chromium that looks at a page of the explorer, and what it must not do meanwhile."""

import contextlib
import json
import re
import shutil
import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest
import uvicorn

from tests.helpers.report_case import PROVENANCE, VERDICT, make_result, railway_trip
from tgvdp.explorer.compute.asked import Asked
from tgvdp.explorer.exhibit import profiles_of, search_exhibit
from tgvdp.explorer.server.app import Explorer, make_app
from tgvdp.report.tables import result_object

ARGUMENTS = [
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync"),
]
_NAMES = ("chromium", "chromium-browser", "google-chrome")


def await_address(page, part: str) -> None:
    """Wait until the address holds a part, and the page shows what it says."""
    from playwright.sync_api import expect

    expect(page).to_have_url(re.compile(re.escape(part)), timeout=30_000)  # a policy of the page forbids scripts to ask
    expect(page.locator("[aria-busy='true']")).to_have_count(0, timeout=30_000)


def executable() -> str:
    """The browser of this machine; where there is none, the test is skipped."""
    found = next((path for name in _NAMES if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip("no browser on this machine: .ci/browser installs one")
    return found


def open_page(watched, url):
    """Go to an address, and wait until a chosen run has its figures: kernels may have to be compiled."""
    watched.page.goto(url)
    watched.page.wait_for_selector("#figures dl", timeout=300_000)
    return watched.page


@contextlib.contextmanager
def listening(exhibits=(), asked=None) -> Iterator[str]:
    """Address of a server in a thread of its own."""
    explorer = Explorer(exhibits, None if asked is None else Asked(**asked))
    config = uvicorn.Config(make_app(explorer), port=0, log_level="warning", ws="none", timeout_graceful_shutdown=1)
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        assert thread.is_alive()
        time.sleep(0.01)
    yield f"http://127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}"
    server.should_exit = True
    thread.join()


class Watched:
    """A page whose console, errors and requests are written down."""

    def __init__(self, page):
        self.page, self.faults, self.urls = page, [], []
        page.on("console", lambda message: self.faults.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: self.faults.append(str(error)))
        page.on("request", lambda request: self.urls.append(request.url))

    def require_clean(self, home, allowed=()):
        """No error that is not allowed, and no request that leaves the machine."""
        assert [text for text in self.faults if not any(word in text for word in allowed)] == []
        assert [url for url in self.urls if not url.startswith((home, "data:", "blob:"))] == []


def figure(page, name):
    """Text beside a name in the card of the chosen run."""
    return page.locator("#figures dt", has_text=name).locator("xpath=following-sibling::dd[1]").inner_text()


def example_exhibit(name="example", speeds=(38.0, 33.0, 29.0, 26.0, 23.0)):
    """An exhibit of five runs made by hand."""
    result = make_result(railway_trip(), list(speeds))
    content = result_object(result, [VERDICT] * len(speeds), PROVENANCE)
    return search_exhibit(name, json.loads(json.dumps(content)), profiles_of(result))


def large_exhibit(points=200, rows=2000):
    """An exhibit of many points with many rows, made of the small one."""
    result = make_result(railway_trip(), [38.0, 30.0, 23.0])
    content = result_object(result, [VERDICT] * 3, PROVENANCE)
    first, last = content["front"][0], content["front"][-1]
    part = np.linspace(0.0, 1.0, points).tolist()
    content["front"] = [
        first
        | {
            "id": index,
            **{name: first[name] + share * (last[name] - first[name]) for name in ("time_s", "delay_s", "margin_pct")},
            **{name: first[name] + share**0.5 * (last[name] - first[name]) for name in ("energy_kwh", "saved_pct")},
        }
        for index, share in enumerate(part)
    ]
    own = profiles_of(result)["fastest"]
    at = np.linspace(0.0, 1.0, rows) * (len(own["speed_mps"]) - 1)
    columns = {name: np.interp(at, np.arange(len(column)), column) for name, column in own.items()}
    columns["regime"] = columns["regime"].astype(int)
    return search_exhibit("large", content, {"fastest": columns, **{str(index): columns for index in range(points)}})
