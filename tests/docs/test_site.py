"""The site: what stands in its sidebar, which pages are reached, and what the pages of the Python modules name."""

import importlib
import re
import sys

import pytest

from harness_plugins.kit.kits import KITS
from tests.docs.pages import FENCE, ROOT

pytest.importorskip("sphinx")
sys.path.insert(0, str(ROOT / "docs" / "site"))
from generated_pages import MODULES, checks_page, module_page, sidebar

from tests.project import ROOT, page_of

DOCS = ROOT / "docs"
INDEX = page_of("index")
MOST = 50
"""Pages that a sidebar may have."""


def links_of(page):
    """The pages of ``docs`` that a page leads to."""
    prose = FENCE.sub("", page.read_text())
    for link in re.findall(r"\]\(<?([^)\s>#]+\.md)", prose):
        there = (page.parent / link).resolve()
        if DOCS in there.parents and there.is_file():
            yield there


def reached_from(page):
    """Every page to which links lead from a page, itself included."""
    found, waiting = {page}, [page]
    while waiting:
        new = set(links_of(waiting.pop())) - found
        found |= new
        waiting += new
    return found


def test_every_page_is_reached_from_the_index():
    """No page is lost, whether it stands in the sidebar or not."""
    pages = {path for path in DOCS.rglob("*.md") if "generated" not in path.parts}
    assert pages - reached_from(DOCS / "index.md") == set()


def test_a_page_without_a_link_is_not_reached(tmp_path):
    """The mutant: a page links to itself only."""
    (tmp_path / "lost.md").write_text("[here](lost.md)")
    assert reached_from(DOCS / "glossary.md") >= {DOCS / "glossary.md"}
    assert tmp_path / "lost.md" not in reached_from(DOCS / "index.md")


def test_sidebar_is_short():
    """Nobody looks for a page among a hundred."""
    names = [name for names in sidebar(INDEX).values() for name in names]
    assert len(names) == len(set(names)) <= MOST


def test_records_are_in_no_sidebar():
    """They are reached from the studies."""
    assert not [name for names in sidebar(INDEX).values() for name in names if "records" in name]


def test_sidebar_follows_the_list_of_the_index():
    """Each item begins with a caption; other links are no entries, and pages from the code stand under "Look up"."""
    index = "# Top\n[no](no.md)\n\n* **A:** [x](x.md),\n  [y](y.md)\n* [z](z.md)\n* **C:** [c](../CHANGELOG.md)\n"
    told = sidebar(index)
    assert told.pop("Look up")[-1] == "generated/api"
    assert told == {"A": ["x", "y"], "C": ["generated/CHANGELOG"]}


def test_index_reads_on_a_forge():
    """It has no directive, which a forge shows as it is written."""
    assert "{" not in INDEX


@pytest.mark.parametrize("module", [it for it in MODULES if it != "harness_plugins.sb3"])
def test_page_of_a_module_has_every_public_name(module):
    """Those that are imported only when they are first used too."""
    names = getattr(importlib.import_module(module), "__all__", [])
    page = module_page(module)
    assert [name for name in names if not re.search(rf"{re.escape(module)}\.{re.escape(name)}\b", page)] == []
    assert names or f"automodule:: {module}" in page


def test_every_name_of_harness_has_a_directive_of_its_kind():
    """Functions as functions, classes as classes."""
    page = module_page("harness")
    for kind, name in (("autofunction", "run"), ("autofunction", "load_results"), ("autoclass", "RecordRewards")):
        assert f".. {kind}:: harness.{name}\n" in page


def test_page_of_checks_has_every_check(subtests):
    """A row with its name, its level and what it holds."""
    page = checks_page()
    for kind, kit in KITS.items():
        with subtests.test(kind=kind):
            for check in kit.checks:
                assert f"| `{check.name}` | {check.level} | " in page
