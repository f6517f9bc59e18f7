"""A real browser without a window, for pages of reports."""

import json
import shutil
from contextlib import contextmanager

import pytest

_BROWSERS = ("chromium", "chromium-browser", "google-chrome")
_OPTIONS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)
_SECONDS = 90
_OWN = ("file:", "data:", "blob:", "chrome:", "chrome-untrusted:")
"""Addresses of files and of the browser itself."""


def programs():
    """Browser and its driver, or the reason why there are none."""
    browser = next(filter(None, map(shutil.which, _BROWSERS)), None)
    driver = shutil.which("chromedriver")
    if browser is None or driver is None:
        pytest.skip("no Chromium with its chromedriver is installed")
    pytest.importorskip("selenium", reason="selenium is not installed")
    return browser, driver


@contextmanager
def started(folder):
    """Start a browser with an empty profile in a folder; it ends with the context."""
    browser, driver = programs()
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = browser
    for option in (*_OPTIONS, f"--user-data-dir={folder}"):
        options.add_argument(option)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    running = webdriver.Chrome(options=options, service=Service(driver))
    try:
        yield running
    finally:
        running.quit()


def open_page(running, page, width):
    """Open a file in a window of some width (pixels), and wait until its scripts have ended."""
    from selenium.webdriver.support.ui import WebDriverWait

    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600}
    running.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    running.get(page.resolve().as_uri())
    ready = "const set = document.documentElement.dataset; return 'ready' in set || 'failed' in set"
    WebDriverWait(running, _SECONDS).until(lambda now: now.execute_script(ready))
    assert running.execute_script("return document.documentElement.dataset.failed") is None


def until(running, script):
    """Wait until a script gives something true, and return it."""
    from selenium.webdriver.support.ui import WebDriverWait

    return WebDriverWait(running, _SECONDS).until(lambda now: now.execute_script(script))


def complaints(running):
    """Errors on the console so far."""
    return [entry for entry in running.get_log("browser") if entry["level"] == "SEVERE"]


def foreign_addresses(running):
    """Addresses asked for so far that lie on a network."""
    messages = (json.loads(entry["message"])["message"] for entry in running.get_log("performance"))
    asked = [
        message["params"]["request"]["url"]
        for message in messages
        if message["method"] == "Network.requestWillBeSent"
    ]
    assert asked, "nothing was recorded"
    return [address for address in asked if not address.startswith(_OWN)]
