"""Takes the pictures of the README and of the tutorial, from the pages of the two experiments that these make.

    harness demo --out my-first
    harness run --sim mujoco --algo sac --task fd100-small-target --reward dense --seeds 8 --out first
    python docs/pictures/take.py my-first first --chromium /usr/bin/chromium

It needs Playwright and Pillow, of the group dev and the extra video, and a Chromium. The films, `reach.gif` and
those of the studies, are made by `harness video`.
"""

import argparse
import io
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import Page, sync_playwright

HERE = Path(__file__).parent
WIDTH, HEIGHT, AIR = 1200, 900, 16


def main() -> None:
    """Take every picture."""
    parser = argparse.ArgumentParser(description="Takes the pictures of the README and of the tutorial.")
    parser.add_argument("demo", type=Path, help="the folder of harness demo")
    parser.add_argument("first", type=Path, help="the folder of the tutorial's run")
    parser.add_argument("--chromium", default="/usr/bin/chromium", help="the browser")
    given = parser.parse_args()
    with sync_playwright() as playwright:
        flags = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]  # WebGL 2 without a graphics card
        browser = playwright.chromium.launch(executable_path=given.chromium, args=flags)
        page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, color_scheme="light")
        page.goto((given.demo / "report.html").resolve().as_uri())
        page.wait_for_timeout(2000)  # the arms are drawn
        _take(page, "demo", "h1", ".card")
        page.goto((given.first / "report.html").resolve().as_uri() + "#replay-1")
        page.wait_for_timeout(3000)
        _take(page, "first-answer", "h1", ".comparison >> nth=0")
        _take(page, "first-replay", "#see", "#replay-player")
        browser.close()


def _take(page: Page, name: str, first: str, last: str) -> None:
    """The page from the top of one element to the bottom of another one, with some air around."""
    top, end = _box(page, first), _box(page, last)
    bottom = end["y"] + end["height"]
    clip: Any = {"x": 0, "y": top["y"] - AIR, "width": WIDTH, "height": bottom - top["y"] + 2 * AIR}
    shot = Image.open(io.BytesIO(page.screenshot(full_page=True, clip=clip)))
    shot.convert("RGB").save(HERE / f"{name}.png", optimize=True)


def _box(page: Page, selector: str) -> Any:
    """Where an element stands, from the page's top."""
    page.evaluate("scrollTo(0, 0)")
    box = page.locator(selector).first.bounding_box()
    assert box, f"the page has no {selector}"
    return box


if __name__ == "__main__":
    main()
