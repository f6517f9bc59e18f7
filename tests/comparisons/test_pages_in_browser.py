"""Reports in a real browser: tables sort, points and phases show shapes, nothing is asked for."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

from comparisons.run_report import write_run_report
from scenes import load_scene, run_modes, save_result

EVIL = """</script><script>document.title = "broken"</script><img src=x onerror="top.evil=1">"""
SCENE = load_scene("drum").on("fe").change("analysis.max_frequency", 0.3)
OPTIONS = [
    *("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
]


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """A real browser without a window and with an empty profile."""
    names = ("chromium", "chromium-browser", "google-chrome")
    binary = next(filter(None, map(shutil.which, names)), None)
    driver = shutil.which("chromedriver")
    if binary is None or driver is None:
        pytest.skip("no Chromium with its chromedriver is installed")
    pytest.importorskip("selenium", reason="selenium is not installed")
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = binary
    for option in (*OPTIONS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(option)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    with webdriver.Chrome(options=options, service=Service(driver)) as running:
        yield running


def until(running, script):
    """Wait until a script gives something true, and return it."""
    from selenium.webdriver.support.ui import WebDriverWait

    return WebDriverWait(running, 90).until(lambda now: now.execute_script(script))


def shown(running):
    """The mode whose shape is shown."""
    return running.find_element("class name", "viewer").get_attribute("data-shown")


def click(running, element):
    script = "arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})"
    running.execute_script(script, element)
    element.click()


@pytest.fixture(scope="module")
def result(browser):
    return run_modes(replace(SCENE, name=EVIL, description=EVIL))


@pytest.fixture(scope="module")
def page(browser, result, tmp_path_factory):
    """The report of a run, opened in a wide window; it stays open between tests."""
    record = save_result(result, tmp_path_factory.mktemp("a run") / "result.json")
    size = {"width": 1400, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.get(write_run_report(result, record).resolve().as_uri())
    set_by_scripts = "document.documentElement.dataset"
    until(browser, f"return 'ready' in {set_by_scripts} || 'failed' in {set_by_scripts}")
    assert browser.execute_script(f"return {set_by_scripts}.failed") is None
    return browser


@pytest.mark.slow
def test_a_click_on_a_heading_sorts(page, result):
    heading = page.find_element("css selector", "#modes thead th:nth-child(4) button")
    cells = """return [...document.querySelectorAll("#modes tbody tr td:nth-child(4)")]
        .map((cell) => Number(cell.dataset.value))"""
    growth = sorted(result.growth_rates.tolist())
    for expected in (growth, growth[::-1]):
        click(page, heading)
        assert page.execute_script(cells) == expected
    heading.send_keys("\ue007")  # Enter: the keyboard sorts as the mouse does
    assert page.execute_script(cells) == growth


def test_texts_of_scenes_stay_texts_and_the_most_unstable_mode_is_shown(page, result):
    assert page.title == EVIL
    assert page.find_element("tag name", "h1").text == EVIL
    assert page.execute_script("return top.evil") is None
    (first,) = result.most_unstable(1)
    assert shown(page) == f"run/{first + 1}"
    assert "▲" in page.find_element("class name", "told").text


DEPTHS = "return [...document.querySelector('.scene').data[0].x]"
PLACE = """
const place = document.getElementById("plot-stability");
place.scrollIntoView({block: 'center', behavior: 'instant'});
const { xaxis, yaxis, _size } = place._fullLayout;
const box = place.getBoundingClientRect();
const data = place.data[0], point = data.customdata.findIndex((key) => key !== arguments[0]);
return [data.customdata[point], box.left + xaxis._offset + xaxis.d2p(data.x[point]),
        box.top + yaxis._offset + yaxis.d2p(data.y[point])];
"""


def test_a_click_on_a_point_shows_its_mode_and_nothing_is_asked_for(page):
    from selenium.webdriver.common.action_chains import ActionChains

    before = page.execute_script(DEPTHS)
    key, x, y = page.execute_script(PLACE, shown(page))
    mouse = ActionChains(page)
    mouse.w3c_actions.pointer_action.move_to_location(round(x), round(y))
    mouse.pause(0.3)
    mouse.w3c_actions.pointer_action.click()
    mouse.perform()
    until(page, f"return document.querySelector('.viewer').dataset.shown === '{key}'")
    until(page, f"return JSON.stringify((() => {{{DEPTHS}}})()) !== {str(before)!r}")
    assert page.execute_script("return document.querySelector('tr.shown').dataset.mode") == key
    assert [entry for entry in page.get_log("browser") if entry["level"] == "SEVERE"] == []
    messages = (json.loads(entry["message"])["message"] for entry in page.get_log("performance"))
    sent = [m["params"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    own = ("file:", "data:", "blob:", "chrome:", "chrome-untrusted:")
    assert sent
    assert [each for each in sent if not each["request"]["url"].startswith(own)] == []


@pytest.mark.slow
def test_the_phase_moves_the_shape(page):
    """Half a period on, every point is as far on the other side; a whole one on, where it was."""

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


def test_a_row_of_a_table_shows_its_mode(page):
    row = page.find_elements("css selector", "#modes tr[data-mode]")[1]
    click(page, row.find_element("css selector", "button.show"))
    key = row.get_attribute("data-mode")
    until(page, f"return document.querySelector('.viewer').dataset.shown === '{key}'")
