"""Reports in a real browser: tables sort, points and phases show shapes, nothing is asked for."""

import json
import shutil
from dataclasses import replace

import pytest
from small_study import STUDY, Options

from comparisons.run_report import write_run_report
from comparisons.study.page import write_study
from comparisons.study.run import run
from scenes import load_scene, run_modes, save_result

EVIL = """</script><script>document.title = "broken"</script><img src=x onerror="top.evil=1">"""
IN_SIGHT = "arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})"
DEPTHS = "return [...document.querySelector('.scene').data[0].x]"
CENTRE = """
const trace = arguments[0], point = arguments[1];
const place = document.getElementById("plot-stability");
const { xaxis, yaxis, _size } = place._fullLayout;
const box = place.getBoundingClientRect();
return [box.left + xaxis._offset + xaxis.d2p(place.data[trace].x[point]),
        box.top + yaxis._offset + yaxis.d2p(place.data[trace].y[point])];
"""


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


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """A real browser without a window and with an empty profile."""
    binary, driver = programs()
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = binary
    for option in (*_OPTIONS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(option)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    with webdriver.Chrome(options=options, service=Service(driver)) as running:
        yield running


def until(running, script):
    """Wait until a script gives something true, and return it."""
    from selenium.webdriver.support.ui import WebDriverWait

    return WebDriverWait(running, 90).until(lambda now: now.execute_script(script))


def open_page(running, page, width):
    """Open a file in a window of some width (pixels), and wait until its scripts have ended."""
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600}
    running.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    running.get(page.resolve().as_uri())
    set_by_scripts = "document.documentElement.dataset"
    until(running, f"return 'ready' in {set_by_scripts} || 'failed' in {set_by_scripts}")
    assert running.execute_script(f"return {set_by_scripts}.failed") is None


def check_quiet(running):
    """No error stands on the console so far, and nothing was asked for from a network."""
    assert [entry for entry in running.get_log("browser") if entry["level"] == "SEVERE"] == []
    messages = (json.loads(entry["message"])["message"] for entry in running.get_log("performance"))
    asked = [
        message["params"]["request"]["url"]
        for message in messages
        if message["method"] == "Network.requestWillBeSent"
    ]
    assert asked, "nothing was recorded"
    assert [address for address in asked if not address.startswith(_OWN)] == []


@pytest.fixture(scope="module")
def result():
    programs()
    scene = load_scene("drum").on("fe").change("analysis.max_frequency", 0.3)
    return run_modes(replace(scene, name=EVIL, description=EVIL))


@pytest.fixture(scope="module")
def report(result, tmp_path_factory):
    folder = tmp_path_factory.mktemp("a run")
    return write_run_report(result, save_result(result, folder / "result.json"))


@pytest.fixture(scope="module")
def page(browser, report):
    """The report of a run, opened in a wide window; it stays open between tests."""
    open_page(browser, report, 1400)
    return browser


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """The page of a study with plots, tables and modes."""
    programs()
    out = tmp_path_factory.mktemp("a study")

    def evaluate(case, session):
        modes = session.solve(load_scene("drum").on("fe").change("analysis.max_frequency", 0.3))
        session.keep_modes("drum", modes, range(2))
        rows = modes.table()[:3]
        return [{"shape": f"drum/{r['mode']}", "mode": r["mode"], "square": 1.0} for r in rows]

    sections = [replace(STUDY.sections[0], modes=True)]
    made = replace(STUDY, evaluate=evaluate, sections=sections)
    return write_study(made, run(made, Options(sizes=(1,)), out), out)


GROWTH = """return [...document.querySelectorAll("#modes tbody tr td:nth-child(4)")]
.map((cell) => Number(cell.dataset.value))"""


@pytest.mark.slow
def test_a_click_on_a_heading_sorts(page, result):
    heading = page.find_element("css selector", "#modes thead th:nth-child(4) button")
    growth = sorted(result.growth_rates.tolist())
    for expected in (growth, growth[::-1]):
        page.execute_script(IN_SIGHT, heading)
        heading.click()
        assert page.execute_script(GROWTH) == expected
    heading.send_keys("\ue007")  # Enter: the keyboard sorts as the mouse does
    assert page.execute_script(GROWTH) == growth


def test_texts_of_scenes_stay_texts(page):
    assert page.title == EVIL
    assert page.find_element("tag name", "h1").text == EVIL
    assert page.execute_script("return top.evil") is None


def test_the_most_unstable_mode_is_shown_first(page, result):
    (first,) = result.most_unstable(1)
    shown = page.find_element("class name", "viewer").get_attribute("data-shown")
    assert shown == f"run/{first + 1}"
    assert "▲" in page.find_element("class name", "told").text


def test_a_click_on_a_point_shows_its_mode(page):
    from selenium.webdriver.common.action_chains import ActionChains

    keys = page.execute_script(
        "const place = document.getElementById('plot-stability');"
        "place.scrollIntoView({block: 'center', behavior: 'instant'});"
        "return place.data[0].customdata"
    )
    assert len(keys) > 1
    before = page.execute_script(DEPTHS)
    shown = page.find_element("class name", "viewer").get_attribute("data-shown")
    point = next(i for i, key in enumerate(keys) if key != shown)
    x, y = page.execute_script(CENTRE, 0, point)
    mouse = ActionChains(page)
    mouse.w3c_actions.pointer_action.move_to_location(round(x), round(y))
    mouse.pause(0.3)
    mouse.w3c_actions.pointer_action.click()
    mouse.perform()
    chosen = f"return document.querySelector('.viewer').dataset.shown === '{keys[point]}'"
    until(page, chosen)
    until(page, f"return JSON.stringify((() => {{{DEPTHS}}})()) !== {str(before)!r}")
    assert (
        page.execute_script("return document.querySelector('tr.shown').dataset.mode")
        == (keys[point])
    )


@pytest.mark.slow
def test_the_phase_moves_the_shape(page, result):
    """Half a period on, every point is as far on the other side; a whole one on, where it was."""
    import numpy as np

    def at(phase):
        page.execute_script(
            "const slider = document.querySelector('.phase');"
            "slider.value = arguments[0]; slider.dispatchEvent(new Event('input'))",
            phase,
        )
        until(page, f"return document.querySelector('.viewer').dataset.phase === '{phase}'")
        return np.array(page.execute_script(DEPTHS))

    begin, quarter, half = at(0), at(90), at(180)
    rest = (begin + half) / 2
    moved = np.abs(begin - rest).max()
    assert moved > 1e-3 * np.ptp(rest)
    assert np.abs(quarter - begin).max() > 0.1 * moved
    np.testing.assert_allclose(at(90) + at(270), 2 * rest, atol=1e-4 * np.ptp(rest))


def test_nothing_was_complained_of_and_nothing_asked_for(page):
    """After all that was done to the page."""
    check_quiet(page)


@pytest.mark.slow
@pytest.mark.parametrize("width", [1400, 390])
@pytest.mark.parametrize("name", ["report", "study"])
def test_no_page_scrolls_sideways(browser, name, width, request):
    open_page(browser, request.getfixturevalue(name), width)
    wide, window = browser.execute_script(
        "return [document.documentElement.scrollWidth, innerWidth]"
    )
    assert window == width
    assert wide <= width
    # What is cut off is out of reach: all but what scrolls by itself ends inside the window.
    outside = browser.execute_script(
        "return [...document.querySelectorAll('main > *, section > *, figure, .controls > *')]"
        ".filter((part) => part.getBoundingClientRect().right > innerWidth + 1)"
        ".map((part) => part.outerHTML.slice(0, 80))"
    )
    assert outside == []
    check_quiet(browser)


@pytest.mark.slow
def test_a_row_of_a_study_shows_its_mode(browser, study):
    open_page(browser, study, 1400)
    shown = "return document.querySelector('.viewer').dataset.shown"
    until(browser, f"{shown} === 'drum/1'")
    rows = browser.find_elements("css selector", "#squares tr[data-mode]")
    assert [row.get_attribute("data-mode") for row in rows] == ["drum/1", "drum/2"]
    button = rows[1].find_element("css selector", "button.show")
    browser.execute_script(IN_SIGHT, button)
    button.click()
    until(browser, f"{shown} === 'drum/2'")
