"""The page in a real browser: Debian's `chromium` and `chromium-driver`, skipped without them."""

import json
import shutil

import numpy as np
import pytest
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select, WebDriverWait

from tests.report.conftest import FAILED, GRANITE, JOINTS

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not (CHROMIUM and DRIVER),
        reason="no browser: apt-get install chromium chromium-driver",
    ),
]


@pytest.fixture(scope="module")
def driver():
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"):
        options.add_argument(word)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    with webdriver.Chrome(options, webdriver.ChromeService(DRIVER)) as browser:
        yield browser


@pytest.fixture(scope="module")
def path(tmp_path_factory, page):
    path = tmp_path_factory.mktemp("page") / "report.html"
    path.write_text(page, encoding="utf-8")
    return path


@pytest.fixture
def browser(driver, path):
    """The page, just loaded at desktop width."""
    return opened(driver, path, 1280)


def opened(driver, path, width: int):
    screen = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    for kind in ("browser", "performance"):
        driver.get_log(kind)  # what came before is not this page's
    driver.get(path.as_uri())
    WebDriverWait(driver, 60).until(lambda d: d.find_elements(By.CSS_SELECTOR, "#explored td"))
    return driver


def requested(driver) -> list[str]:
    messages = [json.loads(entry["message"])["message"] for entry in driver.get_log("performance")]
    return [
        message["params"]["request"]["url"]
        for message in messages
        if message["method"] == "Network.requestWillBeSent"
    ]


def column(browser, sheet: str, title: str) -> list[str]:
    """Texts of a column of a table, of the rows that are seen."""
    return browser.execute_script(
        """
        const [sheet, title] = arguments, table = document.querySelector(`#${sheet} table`);
        const at = [...table.tHead.rows[0].cells].findIndex((c) => c.textContent === title);
        const rows = [...table.tBodies[0].rows].filter((row) => !row.hidden);
        return rows.map((row) => row.cells[at].textContent);
        """,
        sheet,
        title,
    )


def heading(browser, sheet: str, title: str):
    cells = browser.find_elements(By.CSS_SELECTOR, f"#{sheet} thead th")
    return next(cell for cell in cells if cell.text.startswith(title))


def curves(browser) -> list[dict]:
    """Names and points of the curves that are drawn."""
    return browser.execute_script(
        "return document.getElementById('explorer').data.map(({name, x, y}) => ({name, x, y}))"
    )


def drawn(browser) -> list[str]:
    """Paths of the curves, as they are drawn."""
    lines = browser.find_elements(By.CSS_SELECTOR, "#explorer .scatterlayer path.js-line")
    return [line.get_attribute("d") for line in lines]


def choose(browser, menu: str, text: str) -> None:
    Select(browser.find_element(By.ID, f"choose-{menu}")).select_by_visible_text(text)


def test_the_page_loads_without_a_word_on_the_console_and_asks_for_nothing(browser, path):
    assert browser.get_log("browser") == []
    urls = requested(browser)
    assert urls[0] == path.as_uri()
    assert all(url.startswith("data:") for url in urls[1:])


def test_the_page_cannot_ask_for_anything(browser):
    answer = browser.execute_async_script(
        """
        const done = arguments[0];
        document.addEventListener("securitypolicyviolation", (e) => done(e.effectiveDirective));
        fetch("http://localhost:9/").catch(() => null);
        """
    )
    assert answer == "connect-src"


def test_tables_sort_by_number_and_what_is_absent_stays_last(browser):
    head = heading(browser, "intervals", "Length")
    button = head.find_element(By.TAG_NAME, "button")
    before = column(browser, "intervals", "Length")
    button.click()
    assert head.get_attribute("aria-sort") == "ascending"
    rising = column(browser, "intervals", "Length")
    assert sorted(rising) == sorted(before)
    known = [float(text) for text in rising if text != "–"]
    assert known == sorted(known)
    assert len(known) > 2
    button.send_keys(Keys.ENTER)  # by keyboard too
    assert head.get_attribute("aria-sort") == "descending"
    falling = column(browser, "intervals", "Length")
    assert [float(text) for text in falling if text != "–"] == known[::-1]
    absent = falling.count("–")
    assert falling[len(falling) - absent :] == ["–"] * absent
    heading(browser, "intervals", "Rock").find_element(By.TAG_NAME, "button").click()
    assert head.get_attribute("aria-sort") is None
    rocks = column(browser, "intervals", "Rock")
    assert rocks == sorted(rocks)


def test_the_figure_shows_the_joints_and_their_mean(browser, study):
    shown = curves(browser)
    joints = [c for c in shown if c.get("name") and c["name"].startswith("joint 0, cycle 1, load")]
    own = study.sel(case="slate-base", realization=0, cycle=1, branch="loading").closure.values
    np.testing.assert_allclose(joints[0]["x"], 1e3 * own, rtol=1e-3, atol=1e-9)
    assert not any(c["name"] and c["name"].startswith(f"joint {FAILED},") for c in shown)
    assert len(drawn(browser)) > 40
    assert column(browser, "explored", "Joints (n)") == [f"{JOINTS - 1} of {JOINTS}"] * 2


def test_every_menu_changes_the_curves(browser):
    seen = [drawn(browser)]
    for menu, text in (
        ("rock", GRANITE), ("parameter", "Young's modulus"), ("level", "55 GPa"), ("cycle", "2"),
        ("origin", "0.5 MPa of the cycle's loading"),
    ):  # fmt: skip
        choose(browser, menu, text)
        assert drawn(browser) not in seen, menu
        seen.append(drawn(browser))
    assert browser.get_log("browser") == []
    title = browser.find_element(By.ID, "explored-title").text
    assert title.startswith(f"{GRANITE}, Young's modulus: closure from 0.5 MPa")
