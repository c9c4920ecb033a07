"""Every `pip install` line of the pages, typed in a new environment where the wheel of this checkout is there."""

import re
import shlex
import subprocess
from types import MappingProxyType

import pytest

from tests.installed.conftest import ROOT, make_environment

PAGES = (ROOT / "README.md", *sorted(ROOT.glob("docs/**/*.md")), *sorted(ROOT.glob("examples/*/README.md")))
IN_A_FENCE = re.compile(r"^```.*?\n(.*?)^```", re.MULTILINE | re.DOTALL)
IN_A_SENTENCE = re.compile(r"`([^`]*)`")
PIP_LINE = re.compile(r"pip install [^\n]*")

NOT_TYPED = MappingProxyType(
    {
        "--index-url": "asks another package index for torch; `make dev TORCH_INDEX=` of the workflow does it",
        "my-reward": "the name of a package that its author has published",
        "fd100-harness==": "the steps of a release: the version is on an index then",
    }
)
"""Lines that cannot be typed here, by a part of them, and why."""
WRITTEN_FIRST = {"my-reward": "reward", "my-method": "algorithm", "my-task": "task", "my-engine": "simulator"}
"""Packages of which the page has `harness new-plugin` write the folder, and their kind."""


def pip_lines(text):
    """The lines of a page, from its blocks of code and from within sentences."""
    blocks = IN_A_FENCE.findall(text)
    spans = [" ".join(span.split()) for span in IN_A_SENTENCE.findall(IN_A_FENCE.sub("", text))]
    return [line.strip() for part in (*blocks, *spans) for line in PIP_LINE.findall(part)]


LINES = {line: page for page in reversed(PAGES) for line in pip_lines(page.read_text())}
"""Each distinct line, and the first page that has it."""


def reason_not_to(line):
    """Why a line is not typed here; empty if it is."""
    if any(part in line for part in ("-e ", "--editable ")):
        return ""  # a folder, of whatever name
    return next((reason for part, reason in NOT_TYPED.items() if part in line), "")


TYPED = [line for line in LINES if not reason_not_to(line)]


def test_lines_are_found():
    """In blocks, in sentences, and where a line of text breaks within."""
    text = "```\npip install .\nother\n```\nSay `pip install\n'a[b]'`, not pip install c; ``x`` `pip install d`"
    assert pip_lines(text) == ["pip install .", "pip install 'a[b]'", "pip install d"]
    assert "pip install '.[mujoco]'" in LINES


@pytest.mark.parametrize("part", NOT_TYPED)
def test_each_reason_has_its_line(part):
    """A reason for a line that no page has any more is deleted."""
    assert [line for line in LINES if part in line and reason_not_to(line)]


@pytest.mark.parametrize("line", TYPED)
def test_no_page_takes_the_harness_from_an_index(line):
    """No index has it. An extra can be named, since that is asked of an installed harness alone."""
    assert not re.search(r"fd100-harness(?!\[)", line), LINES[line]


@pytest.fixture(scope="module")
def checkout(core, tmp_path_factory):
    """What git clones, with the packages that the pages have written first."""
    folder = tmp_path_factory.mktemp("clone") / "fd100-harness"
    subprocess.run(["git", "clone", "--quiet", "--depth", "1", ROOT.as_uri(), str(folder)], check=True)
    for name, kind in WRITTEN_FIRST.items():
        answer = core.harness("new-plugin", kind, name, cwd=folder)
        assert answer.status == 0, answer.err
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("line", TYPED)
def test_line_can_be_typed(
    core,
    with_extras,
    checkout,
    tmp_path,
    line,
):
    """In a new environment; for the checkout itself, in an empty one. The harness works afterwards."""
    arguments = shlex.split(line)[2:]
    (extras,) = re.findall(r"^pip install 'fd100-harness\[(.*)\]'$", line) or [""]
    if extras:
        env = with_extras(tuple(extras.split(",")))
    else:
        of_checkout = arguments[0].startswith(".")
        env = make_environment(tmp_path / "env", None if of_checkout else core)
        env.install(*arguments, cwd=checkout)
    answer = env.harness("describe", cwd=tmp_path)
    assert answer.status == 0, answer.err
    assert "kinematic" in answer.out
