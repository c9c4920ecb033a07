"""The page as a browser shows it: nothing is asked of a server, nothing is cut, and what can be pressed works."""

import csv
import json
import re
from pathlib import Path
from urllib.parse import unquote, urlparse

import pytest

from harness.report import Report, write_html
from tests.report.conftest import build_results

pytestmark = pytest.mark.slow
WIDTHS = (1440, 768, 390)


@pytest.fixture(scope="module")
def matrix(tmp_path_factory):
    """The page of 24 comparisons of long runs, of which 8 hurt."""
    folder = tmp_path_factory.mktemp("experiment")
    results = build_results(
        folder,
        seeds=6,
        simulators=tuple(f"engine-{number}" for number in range(8)),
        baseline=(700, 1_300),
        proposed={"arp": (700, 1_300), "relative": (50, 1_950), "a-<b>long</b>-name-of-a-reward": (700, 1_300)},
        reached={"baseline": lambda seed: (5, 6, 7, 8), "arp": lambda seed: (), "relative": lambda seed: (8,)},
        learned={10: 1, 20: 2},
    )
    write_html(Report(results), folder / "report.html")
    return (folder / "report.html").as_uri()


@pytest.fixture(scope="module")
def single(tmp_path_factory):
    """The page of one comparison, six cells."""
    folder = tmp_path_factory.mktemp("experiment")
    write_html(Report(build_results(folder, learned={10: 1, 20: 2})), folder / "report.html")
    return (folder / "report.html").as_uri()


def open_all(page):
    """Unfold everything."""
    page.evaluate("document.querySelectorAll('main details').forEach((part) => { part.open = true })")


def size_of(address):
    """Of the file, [bytes]."""
    return Path(unquote(urlparse(address).path)).stat().st_size


def show_table(page):
    """Unfold the table of a page with many comparisons."""
    page.get_by_text("Every comparison with its numbers").click()
    return page


def printed_pages(page):
    """On how many sheets of A4 a browser prints it."""
    return len(re.findall(rb"/Type\s*/Page\b", page.pdf(format="A4", print_background=True)))


def rows(page):
    """What the table shows, from top to bottom."""
    return page.locator(".overview tbody tr:visible").all_inner_texts()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("which", ["single", "matrix"])
def test_nothing_is_asked_for_and_nothing_overflows(show, request, which, width, scheme):
    """Everything unfolded: the page is as wide as the window, and tables scroll within themselves."""
    address = request.getfixturevalue(which)
    page = show(address, width, scheme)
    open_all(page)
    assert page.complaints == []
    assert page.requests == [address]
    assert page.evaluate("document.documentElement.scrollWidth") == width


@pytest.mark.parametrize("width", WIDTHS)
def test_no_label_of_a_figure_is_cut(show, single, width):
    """Every text lies within its figure's column, or within the window."""
    page = show(single, width)
    open_all(page)
    cut = page.evaluate(
        """[...document.querySelectorAll("svg.chart text")].filter((text) => {
          const box = text.getBoundingClientRect(), around = text.closest("svg").getBoundingClientRect();
          return box.left < around.left - 2 || box.right > Math.max(around.right, 0) + 2;
        }).map((text) => text.textContent)"""
    )
    assert cut == []


def test_page_of_a_matrix_is_small(show, matrix):
    """3 MB, 4 screens and 8 sheets of paper."""
    assert size_of(matrix) < 3e6
    page = show(matrix)
    assert page.evaluate("document.documentElement.scrollHeight") <= 4 * 900
    assert printed_pages(page) <= 8


@pytest.mark.parametrize("width", [1440, 390])
def test_the_answer_is_on_the_first_screen(show, single, width):
    """Its sentence, what decides, and the pay."""
    page = show(single, width)
    for part in (".badge", ".lead", ".row .strip", ".pay"):
        box = page.locator(f"main {part}").first.bounding_box()
        assert box["y"] + box["height"] <= 900, part


def test_a_table_is_cards_on_a_telephone(show, single):
    """A card for each measure, none of whose values is cut; it opens by its heading."""
    page = show(single, 390)
    row = page.locator("section[aria-labelledby=does] .grid tbody tr").first
    assert not row.is_visible()
    page.locator("#does").click()
    assert row.evaluate("(it) => getComputedStyle(it).display") == "block"
    assert row.locator("td").evaluate_all("(all) => all.every((it) => it.getBoundingClientRect().right <= innerWidth)")


def test_a_command_is_copied(show, single):
    """Into the clipboard; where the browser forbids that, it is selected."""
    page = show(single)
    page.get_by_role("button", name="Copy").first.click()
    page.wait_for_function(
        "() => [...document.querySelectorAll('.copied button')].some((it) => it.textContent !== 'Copy')"
    )
    said = page.locator(".copied button").first.inner_text()
    assert said == "Copied" or page.evaluate("getSelection().toString()").startswith("harness run")


def test_dark_screen_has_a_dark_page(show, single):
    """And light ink."""
    colours = "[getComputedStyle(document.body).backgroundColor, getComputedStyle(document.body).color]"
    assert show(single).evaluate(colours) == ["rgb(255, 255, 255)", "rgb(22, 25, 29)"]
    assert show(single, scheme="dark").evaluate(colours) == ["rgb(20, 23, 26)", "rgb(236, 239, 242)"]


def test_heading_sorts_the_table(show, matrix):
    """By numbers, upwards and then downwards; the heading says which."""
    page = show_table(show(matrix))
    heading = page.get_by_role("button", name="success")
    values = page.locator(".overview tbody tr td:nth-child(4)")
    heading.click()
    upwards = [float(text.partition("→ ")[2].rstrip("% \u202f")) for text in values.all_inner_texts()]
    heading.click()
    assert upwards == sorted(upwards)
    assert [float(it.partition("→ ")[2].rstrip("% \u202f")) for it in values.all_inner_texts()] == upwards[::-1]
    assert page.locator(".overview th[aria-sort=descending]").all_inner_texts() == ["success"]


def test_filter_leaves_what_fits(show, matrix):
    """All words, and the answer."""
    page = show_table(show(matrix))
    assert len(rows(page)) == 24
    page.get_by_label("Filter").fill("engine-3 arp")
    assert [row.split()[:4] for row in rows(page)] == [["engine-3", "·", "arp", "HURTS"]]
    page.get_by_label("Filter").fill("")
    page.get_by_label("The robot").select_option("hurts")
    assert len(rows(page)) == 8
    assert page.locator("output").inner_text() == "8 of 24"


def test_cell_of_the_map_opens_its_comparison(show, matrix):
    """And the address of an opened comparison can be given to others."""
    page = show(matrix)
    page.locator(".map td a").nth(5).click()
    opened = page.locator("details.folded[open]")
    opened.wait_for()
    assert opened.count() == 1
    name = opened.locator("xpath=..").get_attribute("id")
    assert page.url.endswith(f"#{name}")
    page.reload()
    page.locator(f"#{name} details.folded[open]").wait_for()


def test_index_stays_in_sight(show, matrix):
    """At the end of the page too."""
    page = show(matrix)
    page.evaluate("scrollTo(0, document.documentElement.scrollHeight)")
    assert page.locator("nav").bounding_box()["y"] == 0.0
    page.locator("nav summary").click()
    page.locator("nav ol a").nth(3).click()
    assert page.locator("nav details[open]").count() == 0
    assert page.url.endswith("#combination-4")


@pytest.mark.parametrize("name", ["comparisons.csv", "report.json"])
def test_files_can_be_saved(show, matrix, tmp_path, name):
    """Out of the page itself."""
    page = show(matrix)
    with page.expect_download() as download:
        page.get_by_role("button", name=name).click()
    download.value.save_as(tmp_path / name)
    text = (tmp_path / name).read_text()
    found = list(csv.DictReader(text.splitlines())) if name.endswith("csv") else json.loads(text)["combinations"]
    assert len(found) == 24


def test_keyboard_reaches_every_control(show, matrix):
    """Links, buttons, folds and tables that scroll, by the tabulator alone."""
    page = show(matrix)
    controls = page.locator("a:visible, button:visible, summary:visible, input:visible, select:visible, pre:visible")
    reached = set()
    for _ in range(controls.count() + 10):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("[...document.querySelectorAll('*')].indexOf(document.activeElement)"))
    everything = controls.evaluate_all("(all) => all.map((one) => [...document.querySelectorAll('*')].indexOf(one))")
    assert set(everything) <= reached


def test_keyboard_works_every_control(show, matrix):
    """Enter and the space bar sort, unfold, filter, lead to a place and save a file."""
    page = show_table(show(matrix))
    page.get_by_role("button", name="pay of an episode").press("Enter")
    assert page.locator("th[aria-sort=ascending]").inner_text().startswith("pay")
    page.get_by_role("button", name="pay of an episode").press("Space")
    assert page.locator("th[aria-sort=descending]").inner_text().startswith("pay")
    fold = page.locator("main summary").first
    for key, is_open in (("Enter", True), ("Space", False)):
        fold.press(key)
        assert fold.evaluate("(it) => it.parentElement.open") is is_open
    page.get_by_label("The robot").press("h")
    assert page.get_by_label("The robot").input_value() in ("helps", "hurts")
    page.get_by_label("Filter").press_sequentially("engine-3")
    assert all("engine-3" in row for row in rows(page))
    with page.expect_download():
        page.get_by_role("button", name="comparisons.csv").press("Enter")
    page.locator(".map td a").nth(5).press("Enter")
    page.locator("details.folded[open]").wait_for()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("which", ["single", "matrix"])
def test_nobody_is_kept_out(show, barriers, request, which, scheme):
    """Axe finds nothing serious; of many comparisons the first is unfolded, for the others are built alike."""
    page = show(request.getfixturevalue(which), scheme=scheme)
    page.evaluate(
        "document.querySelector('.comparison').querySelectorAll('details').forEach((it) => { it.open = true })"
    )
    page.evaluate(
        "document.querySelectorAll('main > section:not(.comparison) details').forEach((it) => { it.open = true })"
    )
    assert barriers(page) == []


def test_paper_has_what_the_screen_shows(show, matrix):
    """What is folded stays folded: 24 comparisons with all their tables were 126 sheets."""
    page = show(matrix)
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert page.locator("main details.folded[open]").count() == 0
