"""The replay in a browser: Chromium, without a screen."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from harness.report.html import write_html
from harness.results import Results
from harness.results.replay import shows_of
from harness.robot.kinematics import end_effector_position
from harness.scene.picture import chain_of

pytestmark = pytest.mark.slow
BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
TIPS = "all => all.map((canvas) => canvas.dataset.tip.split(' ').map(Number))"
VIEWS = ".replay-views canvas"


@pytest.fixture
def page(recorded: Results, tmp_path: Path) -> Iterator[Any]:
    """The report of an experiment, opened from its file; an error or a request fails the test that opened it."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is missing: pip install playwright")
    if BROWSER is None:
        pytest.skip("no Chromium on this machine: apt install chromium")
    write_html(recorded, tmp_path / "page.html")
    told: list[str] = []
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=BROWSER, args=FLAGS)
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.on("console", lambda message: told.append(message.text))
        page.on("pageerror", lambda error: told.append(str(error)))
        page.on("request", lambda request: None if request.url.startswith("file:") else told.append(request.url))
        page.goto((tmp_path / "page.html").as_uri() + "#replay-1-1")
        page.wait_for_selector(f"{VIEWS}[data-tip]")
        yield page
        browser.close()
    assert told == []


def test_the_arm_is_seen(page: Any):
    """Each view holds many colours: ground, arm, target, way."""
    count = """all => all.map((canvas) => new Set(new Uint32Array(
      canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.buffer)).size)"""
    assert min(page.eval_on_selector_all(VIEWS, count)) > 100


def test_the_drawn_arm_is_where_kinematics_says(page: Any, recorded: Results):
    """The end effector of both sides, at the start and at the end of an episode."""
    (show,) = shows_of(recorded)
    for share, row in ((0, 0), (1, -1)):
        page.eval_on_selector(
            "[data-part=scrub]", f"it => {{ it.value = {share} * it.max; it.dispatchEvent(new Event('input')); }}"
        )
        page.wait_for_timeout(300)
        expected = [
            end_effector_position(chain_of(side.scene), side.episodes[0].qpos[row]).tolist() for side in show.sides
        ]
        np.testing.assert_allclose(page.eval_on_selector_all(VIEWS, TIPS), expected, atol=1e-3)


def test_play_moves_the_arm_to_the_end(page: Any):
    """The button plays, says what it does next, and the episode ends by itself."""
    before = page.eval_on_selector_all(VIEWS, TIPS)
    page.select_option("[data-part=speed]", "5")
    page.click("[data-part=play]")
    assert page.inner_text("[data-part=play]") == "Pause"
    page.get_by_role("button", name="Play", exact=True).wait_for(timeout=60_000)
    assert page.eval_on_selector_all(VIEWS, TIPS) != before


def test_the_keyboard_is_enough(page: Any):
    """Tab reaches every control, Enter plays, arrows scrub."""
    reached = set()
    page.focus("[data-part=episode]")
    for _ in range(12):
        reached.add(page.evaluate("document.activeElement.dataset.part"))
        page.keyboard.press("Tab")
    assert reached >= {"episode", "play", "scrub", "speed", "left", "right", "above", "below", "nearer", "reset"}
    page.focus("[data-part=play]")
    page.keyboard.press("Enter")
    assert page.inner_text("[data-part=play]") == "Pause"


def test_a_phone_loses_nothing(page: Any):
    """At 390 px the views stand below one another, and nothing is wider than the screen."""
    page.set_viewport_size({"width": 390, "height": 844})
    page.wait_for_timeout(300)
    boxes = [view.bounding_box() for view in page.query_selector_all(VIEWS)]
    assert boxes[1]["y"] > boxes[0]["y"] + boxes[0]["height"]
    wide = "document.querySelector('#replay').scrollWidth <= document.documentElement.clientWidth"
    assert page.evaluate(wide)


def test_a_link_leads_to_an_episode(page: Any):
    """#replay-1-3: the first comparison, its episode 3."""
    page.evaluate("location.hash = '#replay-1-3'")
    page.wait_for_timeout(300)
    assert page.eval_on_selector("[data-part=episode]", "it => it.selectedOptions[0].text").startswith("3:")
