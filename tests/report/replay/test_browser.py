"""The replay in a browser: Chromium, without a screen."""

import re

import numpy as np
import pytest

from harness.report import Report, write_html
from harness.results.replay import shows_of
from harness.robot.kinematics import end_effector_position
from harness.scene.picture import chain_of
from harness_plugins.watch.watch import served
from tests.report.conftest import NO_WEBGL

pytestmark = pytest.mark.slow
COLOURS = """all => all.map((canvas) => new Set(new Uint32Array(
  canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.buffer)).size)"""
TIPS = "all => all.map((canvas) => canvas.dataset.tip.split(' ').map(Number))"
VIEWS = ".replay-views canvas"


@pytest.fixture
def address(recorded, tmp_path):
    """Of the report of an experiment."""
    write_html(Report(recorded), tmp_path / "page.html")
    return (tmp_path / "page.html").as_uri()


@pytest.fixture
def page(show, address):
    """The report at its first episode; an error or a request fails the test that opened it."""
    page = show(f"{address}#replay-1-1")
    page.wait_for_selector(f"{VIEWS}[data-tip]")
    yield page
    assert page.complaints == []
    assert [url for url in page.requests if not url.startswith("file:")] == []


def test_the_arm_is_seen(page):
    """Each view holds many colours: ground, arm, target, way."""
    assert min(page.eval_on_selector_all(VIEWS, COLOURS)) > 100


def test_the_drawn_arm_is_where_kinematics_says(page, recorded):
    """The end effector of both sides, at the start and at the end of an episode."""
    (show,) = shows_of(recorded)
    for share, row in ((0, 0), (1, -1)):
        page.eval_on_selector(
            "[data-part=scrub]", f"it => {{ it.value = {share} * it.max; it.dispatchEvent(new Event('input')); }}"
        )
        expected = [
            end_effector_position(chain_of(side.scene), side.episodes[0].qpos[row]).tolist() for side in show.sides
        ]
        near = (
            "ends => (%s)([...document.querySelectorAll('%s')]).flat().every((it, i) => Math.abs(it - ends[i]) < 1e-3)"
        )
        page.wait_for_function(near % (TIPS, VIEWS), arg=np.ravel(expected).tolist())


def test_play_moves_the_arm_to_the_end(page):
    """The button plays, says what it does next, and the episode ends by itself."""
    before = page.eval_on_selector_all(VIEWS, TIPS)
    page.select_option("[data-part=speed]", "5")
    page.click("[data-part=play]")
    assert page.inner_text("[data-part=play]") == "Pause"
    page.get_by_role("button", name="Play", exact=True).wait_for(timeout=60_000)
    assert page.eval_on_selector_all(VIEWS, TIPS) != before


def test_the_keyboard_is_enough(page):
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


def test_a_phone_loses_nothing(page):
    """At 390 px the views stand below one another, and nothing is wider than the screen."""
    page.set_viewport_size({"width": 390, "height": 844})
    page.wait_for_timeout(300)
    boxes = [view.bounding_box() for view in page.query_selector_all(VIEWS)]
    assert boxes[1]["y"] > boxes[0]["y"] + boxes[0]["height"]
    wide = "document.querySelector('#replay').scrollWidth <= document.documentElement.clientWidth"
    assert page.evaluate(wide)


def test_a_link_leads_to_an_episode(page):
    """#replay-1-3: the first comparison, its episode 3."""
    page.evaluate("location.hash = '#replay-1-3'")
    page.wait_for_timeout(300)
    assert page.eval_on_selector("[data-part=episode]", "it => it.selectedOptions[0].text").startswith("seed 0, 3:")


def test_an_outcome_leads_to_an_episode_that_ended_so(page):
    """Every part of the bars of both rewards; the replay names the outcome of that side."""
    found = 0
    for side, bar in enumerate(page.locator(".bars dd").all()[:2]):
        for part in bar.locator("a").all():
            kind = part.get_attribute("class")
            part.click()
            page.wait_for_function(
                "number => document.querySelector('[data-part=told]').textContent.includes(number)",
                arg=f"Episode {part.get_attribute('href').split('-')[2]} ",
            )
            assert page.locator(".replay-views figcaption b").nth(side).inner_text() == kind
            found += 1
    assert found >= 2


def test_a_measure_leads_to_an_episode(page):
    """Every link of the table of behaviour, pressed by Enter, to the episode that its title names."""
    links = page.locator(".grid.wide td a").all()
    assert len(links) >= 10
    for link in links:
        number, outcome = re.fullmatch(
            r"Watch episode (\d+) of seed 0: .*?([-a-z]+)", link.get_attribute("title")
        ).groups()
        link.press("Enter")
        told = page.get_by_text(f"Episode {number} of the final evaluation, seed 0: ")
        told.wait_for()
        assert outcome in told.inner_text()
    assert page.evaluate("document.activeElement.dataset.part") == "play"


def test_a_link_leads_back_to_its_episode(page):
    """Also where the address is that of the link already, but another episode has been chosen since."""
    page.select_option("[data-part=episode]", index=2)
    page.evaluate("document.querySelector('main a[href^=\"#replay-1-1-\"]').click()")
    assert page.inner_text("[data-part=told]").startswith("Episode 1 ")


def test_a_cell_plays_its_pair(page):
    """By a click, and by arrows and Enter; what is told says how often pairs end so."""
    cells = page.locator("[role=gridcell]")
    assert cells.count() == 4
    cells.nth(2).click()
    assert page.inner_text("[data-part=told]").startswith("Episode 3 of the final evaluation, seed 0: ")
    assert " of 4 pairs." in page.inner_text("[data-part=told]")
    page.keyboard.press("ArrowLeft")
    assert page.evaluate("document.activeElement.title").startswith("Seed 0, episode 2: ")
    page.keyboard.press("Enter")
    assert page.inner_text("[data-part=told]").startswith("Episode 2 ")


def test_the_typical_pair_is_first(show, address, recorded):
    """In the still and in the replay, with its share."""
    (shown,) = shows_of(recorded)
    page = show(address)
    share = shown.pairs.share(shown.pairs.usual)
    assert page.inner_text(".still b").lower() == share.lower()
    told = page.inner_text("[data-part=told]").lower()
    assert told.startswith(f"episode {shown.numbers[shown.first]} ")
    assert share.lower() in told


def test_without_webgl_the_arm_is_a_line(show, address):
    """The page says so in a sentence, and shows how the arm and its tip move."""
    page = show(f"{address}#replay-1-1", flags=NO_WEBGL)
    page.wait_for_selector(f"{VIEWS}[data-tip]")
    assert page.get_by_text("This browser has no WebGL 2: the arm is drawn as a line through its joints.").is_visible()
    assert min(page.eval_on_selector_all(VIEWS, COLOURS)) > 20
    before = page.eval_on_selector_all(VIEWS, TIPS)
    page.locator("[data-part=scrub]").press("End")
    page.wait_for_function("() => document.querySelector('.replay-views canvas').dataset.step > 0")
    assert page.eval_on_selector_all(VIEWS, TIPS) != before


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nobody_is_kept_out(show, barriers, address, scheme):
    """Axe finds nothing serious on a page with a replay, everything unfolded."""
    page = show(address, scheme=scheme)
    page.evaluate("document.querySelectorAll('main details').forEach((part) => { part.open = true })")
    assert barriers(page) == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nobody_is_kept_out_of_the_watch_page(show, barriers, recorded, scheme):
    """Axe finds nothing serious on what ``harness watch`` serves."""
    with served(recorded.folder) as address:
        page = show(address, scheme=scheme)
        page.wait_for_selector(f"{VIEWS}[data-tip]")
        assert barriers(page) == []
