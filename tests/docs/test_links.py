"""The links of the pages: each leads to a file that is there, and to a heading in it."""

import re
import sys

import pytest

from tests.docs.pages import FENCE, PAGES, ROOT

sys.path.insert(0, str(ROOT / "docs" / "pictures"))
import shown

LINKED = [*PAGES, ROOT / "CHANGELOG.md", *sorted(ROOT.glob("results/reference/**/summary.md"))]
LINK = re.compile(r"\]\(<?([^)\s>]+)>?\)")
HEADING = re.compile(r"^#{1,6} +(.+?) *#*$", re.MULTILINE)
TARGET = re.compile(r"^\(([\w-]+)\)=$", re.MULTILINE)


def dead_links(page, text):
    """The relative links of a page that lead nowhere."""
    return [link for link in _links(text) if not _leads_somewhere(page, text, link)]


def _links(text):
    prose = re.sub(r"`[^`\n]*`", "", FENCE.sub("", text))
    yield from (link for link in LINK.findall(prose) if not re.match(r"[a-z]+:", link))


def _leads_somewhere(page, text, link):
    path, _, anchor = link.partition("#")
    there = (page.parent / path).resolve() if path else page
    if path and (not there.exists() or ROOT not in there.parents):
        return False
    if not anchor or there.suffix != ".md":
        return not anchor
    return anchor in anchors_of(there.read_text() if path else text)


def anchors_of(text):
    """What the headings of a page are called in links, as GitHub and the site make it of their words."""
    prose, found = FENCE.sub("", text), set[str]()
    for heading in HEADING.findall(prose):
        words = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").lower()
        slug = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
        count = sum(re.fullmatch(rf"{re.escape(slug)}(?:-\d+)?", it) is not None for it in found)
        found.add(f"{slug}-{count}" if count else slug)
    return found | set(TARGET.findall(prose))


def test_no_link_leads_nowhere(subtests):
    """Neither to a file that is gone, nor to a heading."""
    for page in LINKED:
        with subtests.test(page=page):
            assert dead_links(page, page.read_text()) == []


PAGE = ROOT / "docs" / "page.md"
WRONG = {
    "file": "[a](gone.md)",
    "folder": "[a](../gone/glossary.md)",
    "heading": "[a](glossary.md#gone)",
    "own heading": "# Here\n[a](#there)",
    "picture": "![a](pictures/gone.png)",
    "outside": "[a](../../other/page.md)",
}


@pytest.mark.parametrize(("text", "link"), [(it, LINK.findall(it)[0]) for it in WRONG.values()], ids=WRONG)
def test_link_to_nowhere_is_found(text, link):
    """The mutants."""
    assert dead_links(PAGE, text) == [link]


RIGHT = [
    "[a](glossary.md)",
    "[a](glossary.md#eta_n-and-eta_p)",
    "# Is it `x`?\n[a](#is-it-x)",
    "# A\n# A\n[b](#a-1)",
    "[a](../examples)",
    "[a](https://example.org/x#y)",
    "```\n[a](b)\n```",
    "`[a](b)`",
]


def test_link_that_leads_somewhere_is_left_alone(subtests):
    """Code is no link, and the network is not asked."""
    for text in RIGHT:
        with subtests.test(text=text):
            assert dead_links(PAGE, text) == []


def test_figures_of_records_are_shown(tmp_path, monkeypatch):
    """Those that no page shows are not committed; their lines are taken out of the record's page."""
    assert shown.unshown(ROOT / "results/reference") == []
    monkeypatch.setattr(shown, "ROOT", tmp_path)
    for name in ("one.svg", "other.svg"):
        (tmp_path / name).touch()
    (tmp_path / "README.md").write_text("![a](one.svg)")
    (tmp_path / "summary.md").write_text("# A\n\n![a](one.svg)\n\n![b](other.svg)\n\nEnd\n")
    shown.keep_shown(tmp_path)
    assert (tmp_path / "summary.md").read_text() == "# A\n\n![a](one.svg)\n\nEnd\n"
    assert not (tmp_path / "other.svg").exists()
