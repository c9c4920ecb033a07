"""The live page as a browser shows it, while a training is recorded."""

import time

import numpy as np
import pytest

import harness
from harness_plugins.watch.watch import served
from tests.recorder.conftest import Counting

pytestmark = pytest.mark.slow
LATEST = 5.0
"""Seconds after which a step stands on the page."""


@pytest.fixture
def env(tmp_path):
    """An env that records a training of two terms."""
    rewards = {"counted": {"left": "left", "again": "left"}, "a-<b>long</b>-name-of-a-reward": "left"}
    given = {"behaviour": {"success": "final"}, "seed": 0, "steps_asked": 5_000, "pay": True}
    env = harness.RecordRewards(Counting(), tmp_path / "runs/one", trained_with="counted", rewards=rewards, **given)
    env.reset(seed=0)
    yield env
    env.close()


@pytest.fixture
def address(env, tmp_path):
    """The address of the page."""
    step(env, 90)
    with served(tmp_path / "runs") as address:
        yield address


def step(env, count):
    """Take steps; an episode that ends is followed by the next."""
    for _ in range(count):
        if any(env.step(np.zeros(1, np.float32))[2:4]):
            env.reset()


def steps_on(page):
    """How many steps the page tells."""
    return int(page.locator("article p.soft").first.inner_text().partition(" ")[0].replace(",", ""))


def test_a_step_is_seen_within_five_seconds(show, env, address):
    """On the page, without reloading it, while the training goes on."""
    page = show(address)
    page.evaluate("window.stays = true")
    taken, delays = 90, []
    for _ in range(3):
        step(env, 1_000)
        taken, begun = taken + 1_000, time.monotonic()
        more = 0
        while steps_on(page) < taken:
            step(env, 1)
            more += 1
            time.sleep(0.02)
        taken += more
        delays.append(time.monotonic() - begun)
    assert max(delays) < LATEST
    assert page.evaluate("window.stays")
    assert page.complaints == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1440, 768, 390])
def test_nothing_overflows_and_nobody_is_kept_out(show, barriers, address, width, scheme):
    """The page is as wide as the window, and axe finds nothing; every request goes to the page's own server."""
    page = show(address, width, scheme)
    assert page.evaluate("document.documentElement.scrollWidth") == width
    assert barriers(page) == []
    assert page.complaints == []
    assert all(asked.startswith(address) for asked in page.requests)


def test_the_page_stays_where_it_is(show, env, address):
    """Scrolled down, it is drawn anew without a jump, and what had the focus keeps it."""
    page = show(address, 390)
    page.set_viewport_size({"width": 390, "height": 200})
    page.evaluate("scrollTo(0, 150)")
    step(env, 3_000)
    env.close()
    page.get_by_text("1 training recorded, 1 ended.").wait_for()
    assert page.evaluate("scrollY") == 150


def test_without_scripts_the_state_is_shown(launch, address):
    """As it was when the page was asked for."""
    page = launch().new_context(java_script_enabled=False).new_page()
    page.goto(address)
    assert page.get_by_text("1 training recorded, 1 running.").count() == 1
    assert page.get_by_text("of 5,000 steps").count() == 1
