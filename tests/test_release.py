"""What a release needs besides a build: one version everywhere, and workflows whose targets exist."""

import re
import tomllib

import harness
from harness.registry.spec import API_VERSION
from tests.project import ROOT, page_of

VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]


def test_citation_names_the_version_that_is_built():
    """CITATION.cff and pyproject.toml."""
    assert f"\nversion: {VERSION}\n" in (ROOT / "CITATION.cff").read_text()


def test_the_package_and_the_pages_name_the_version_that_is_built():
    """harness.__version__, and the status on the first page."""
    assert harness.__version__ == VERSION
    assert f"This is version {VERSION}." in page_of("index")


def test_changelog_has_the_version_with_its_date():
    """Below what is not released yet, and above what was released before."""
    headings = re.findall(r"^## (.+)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert headings[0] == "Unreleased"
    assert re.fullmatch(rf"{re.escape(VERSION)} \(\d{{4}}-\d\d-\d\d\)", headings[1])


def test_changelog_of_the_version_is_short():
    """What a user has to know."""
    text = (ROOT / "CHANGELOG.md").read_text().partition(f"\n## {VERSION} (")[2].partition("\n## ")[0]
    assert 200 < len(text.split()) <= 2_000


def test_new_plugins_are_written_for_these_interfaces():
    """The scaffold's, those of the examples that state a version, and the one that the page shows."""
    folders = ("examples", "plugins")
    texts = [path.read_text() for folder in folders for path in (ROOT / folder).rglob("plugin.py*")]
    texts.append(page_of("plugins"))
    stated = {int(it) for text in texts for it in re.findall(r"^harness_api = (\d+)", text, re.MULTILINE)}
    assert stated == {API_VERSION}


def test_workflows_call_targets_that_there_are():
    """Of the Makefile."""
    targets = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    called = re.findall(r"make ([a-z ]+)", "".join(path.read_text() for path in ROOT.glob(".github/workflows/*.yml")))
    assert called
    assert {name for names in called for name in names.split()} <= targets
