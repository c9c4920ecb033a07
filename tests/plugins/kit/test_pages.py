"""The pages "Writing a ...": each shows what a new plugin is, and nothing else."""

import re

import pytest

from harness_plugins.kit.new_plugin import PluginName, kinds, package_files
from tests.project import ROOT, page_of

LONGEST = 140
"""Lines of a page, the code aside: it is short, or nobody reads it."""


@pytest.mark.parametrize("kind", kinds())
def test_page_shows_the_code_of_a_new_plugin(kind):
    """To the letter: who copies it from the page has what the command writes."""
    code = package_files(kind, PluginName(f"my-{kind}"))[f"my_{kind}/{kind}.py"]
    page = f"writing/{kind}"
    assert f"```python\n{code}```" in page_of(page), f"docs/{page}.md shows other code than the template"


def test_page_of_robots_shows_their_settings():
    """Which are no Python."""
    settings = package_files("robot", PluginName("my-robot"))["my_robot/arm/robot.toml"]
    assert f"```toml\n{settings}```" in page_of("writing/robot")


@pytest.mark.parametrize("kind", kinds())
def test_page_answers_what_its_reader_asks(kind):
    """How to begin, what the arguments are, which names count, how to check, time and publish."""
    page = page_of(f"writing/{kind}")
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
    entry, written = page_of("plugins"), [f"writing/{kind}" for kind in kinds()]
    assert all(f"({name}.md)" in entry for name in written)
    for name in ("plugins", *written):
        path = ROOT / "docs" / name
        for link in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page_of(name)):
            assert (path.parent / link).is_file(), f"{name}: {link}"
