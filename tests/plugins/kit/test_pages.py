"""The pages "Writing a ...": each shows what a new plugin is, and nothing else."""

import re
from pathlib import Path

import pytest

from harness_plugins.kit.new_plugin import PluginName, kinds, package_files

DOCS = Path(__file__).parents[3] / "docs"
LONGEST = 140
"""Lines of a page, the code aside: it is short, or nobody reads it."""


def page_of(kind):
    """The page of a kind."""
    return (DOCS / "writing" / f"{kind}.md").read_text()


@pytest.mark.parametrize("kind", kinds())
def test_page_shows_the_code_of_a_new_plugin(kind):
    """To the letter: who copies it from the page has what the command writes."""
    code = package_files(kind, PluginName(f"my-{kind}"))[f"my_{kind}/{kind}.py"]
    assert f"```python\n{code}```" in page_of(kind), f"docs/writing/{kind}.md shows other code than the template"


def test_page_of_robots_shows_their_settings():
    """Which are no Python."""
    settings = package_files("robot", PluginName("my-robot"))["my_robot/arm/robot.toml"]
    assert f"```toml\n{settings}```" in page_of("robot")


@pytest.mark.parametrize("kind", kinds())
def test_page_answers_what_its_reader_asks(kind):
    """How to begin, what the arguments are, which names count, how to check, time and publish."""
    page = page_of(kind)
    for text in (
        f"harness new-plugin {kind} my-{kind}",
        "## Names that must be exact",
        "## Check, time, publish",
        f"harness check my-{kind}",
        "../plugins.md#publishing",
    ):
        assert text in page
    assert re.search(r"^## What the (arguments are|argument is|files say)$", page, re.MULTILINE)
    assert len(re.sub(r"```python\n.*?```", "", page, flags=re.DOTALL).splitlines()) <= LONGEST


def test_entry_page_leads_to_every_page():
    """And every link of these pages leads to a file."""
    entry = (DOCS / "plugins.md").read_text()
    assert all(f"(writing/{kind}.md)" in entry for kind in kinds())
    pages = {DOCS / "plugins.md": entry} | {DOCS / "writing" / f"{kind}.md": page_of(kind) for kind in kinds()}
    for path, page in pages.items():
        for link in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page):
            assert (path.parent / link).is_file(), f"{path.name}: {link}"
