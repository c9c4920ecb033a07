"""The page that says where the note is in the code: it leaves nothing of the note out, and what it names is there."""

import importlib
import importlib.util
import re
from functools import cache

import pytest
import typer.main

from harness.cli.app import build_app
from harness.errors import UsageError
from harness.record import SCALARS
from harness.registry import choose
from tests.project import ROOT
from tests.registered import REGISTRY

PAGE = ROOT / "docs" / "note.md"

NUMBERED = {
    "Equations": [str(number) for number in range(1, 45)],
    "Definitions": [*(f"Definition {number}" for number in range(1, 5)), "Property 1"],
    "Tables": ["I", "II", "III"],
    "Examples": [str(number) for number in range(1, 4)],
    "Figures": [str(number) for number in range(1, 9)],
}
"""By section of the page: what the note numbers."""
COLUMNS = {*SCALARS, "qpos", "action"}
REGISTERED = re.compile(r"\b(reward|task|algorithm|metric) `([^`]+)`")
QUOTED = re.compile(r"`([^`]+)`")
LINK = re.compile(r"\]\(([^)]+)\)")
HEADING = re.compile(r"^## (.+)\n", re.MULTILINE)


def missing_items(page):
    """What the note numbers and the page has no line for, or more than one, or another order."""
    _, *parts = HEADING.split(page)
    sections = dict(zip(parts[::2], parts[1::2], strict=True))
    wrong = []
    for name, items in NUMBERED.items():
        lines = [line for line in sections.get(name, "").splitlines() if line.startswith("| ")]
        found = [line.split(" | ")[0].removeprefix("| ") for line in lines[2:]]
        if found != items:
            wrong.append(f"{name}: {sorted(set(items) ^ set(found)) or 'out of order'}")
    return wrong


def wrong_names(page):
    """Everything in backticks, and every link, that leads nowhere."""
    registered = sorted(set(REGISTERED.findall(page)))
    wrong = [f"{kind} {label}" for kind, label in registered if not _is_registered(f"{kind}s", label)]
    wrong += [name for name in QUOTED.findall(REGISTERED.sub("", page)) if not _leads_somewhere(name)]
    return wrong + [link for link in LINK.findall(page) if not (PAGE.parent / link).is_file()]


def _is_registered(kind, label):
    try:
        choose(REGISTRY, kind, label)
    except UsageError:
        return False
    return True


def _leads_somewhere(name):
    """Whether it is a column of a trace, a command with its options, a path, or a dotted name of ours."""
    if name.startswith("harness "):
        return _is_command(name)
    if "/" in name:
        return (ROOT / name).exists()
    return name in COLUMNS or _is_ours(name)


def _is_command(line):
    _, name, *words = line.split()
    command = _commands().get(name)
    flags = {flag for it in (command.params if command else ()) for flag in (*it.opts, *it.secondary_opts)}
    return command is not None and all(word in flags for word in words if word.startswith("--"))


@cache
def _commands():
    return typer.main.get_command(build_app()).commands


def _is_ours(name):
    """Whether ``package.module.Class.member`` or ``package.module:Class`` can be imported."""
    parts = name.replace(":", ".").split(".")
    if parts[0] not in {"harness", "harness_plugins"}:
        return False
    for count in range(len(parts), 0, -1):
        if _is_module(".".join(parts[:count])):
            thing = importlib.import_module(".".join(parts[:count]))
            for attribute in parts[count:]:
                thing = getattr(thing, attribute, None)
            return thing is not None
    return False


def _is_module(name):
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:  # what stands before its last dot is no package
        return False


def test_page_leaves_nothing_out():
    """Every equation, definition, table, example and figure of the note has its line, in the note's order."""
    assert missing_items(PAGE.read_text()) == []


def test_page_names_what_is_there():
    """Code, registered names, columns, commands, files and links."""
    page = PAGE.read_text()
    assert len(QUOTED.findall(page)) > 100
    assert wrong_names(page) == []


LINES = {"Equations": "| 17 |", "Definitions": "| Definition 4 |", "Tables": "| II |", "Examples": "| 3 |"}


@pytest.mark.parametrize(("section", "line"), {**LINES, "Figures": "| 8 | the acc"}.items(), ids=str)
def test_line_left_out_is_found(section, line):
    """The mutants: a page without one line."""
    page = PAGE.read_text()
    before, heading, after = page.partition(f"## {section}\n")
    assert f"\n{line}" in after
    less = re.sub(rf"\n{re.escape(line)}[^\n]*", "", after, count=1)
    assert [item.partition(":")[0] for item in missing_items(before + heading + less)] == [section]


def test_lines_out_of_order_are_found():
    """Twice the same, or in another order."""
    page = PAGE.read_text()
    (line,) = re.findall(r"^\| 24 \|.*\n", page, re.MULTILINE)
    assert missing_items(page.replace(line, 2 * line)) == ["Equations: out of order"]


MUTANTS = [
    ("harness.eta.index.Index.I_N", "harness.eta.index.Index.I_M"),
    ("harness.eta.index.Index.total", "harness.eta.indices.Index.total"),
    ("harness_plugins.rewards.arp:Arp", "harness_plugins.rewards.arp:App"),
    ("reward `baseline-eq21`", "reward `baseline-eq12`"),
    ("reward `relative:denominator=current`", "reward `relative:denominator=other`"),
    ("task `fd100-reach`", "task `fd100-reech`"),
    ("metric `path_ratio`", "metric `path_length`"),
    ("column `reward_ground`", "column `reward_floor`"),
    ("`robots/fd100/README.md`", "`robots/fd100/READ.md`"),
    ("harness eta --curve", "harness eta --carve"),
    ("harness run --stochastic", "harness ran --stochastic"),
    ("(tasks.md)", "(task.md)"),
]


@pytest.mark.parametrize(("right", "wrong"), MUTANTS, ids=[wrong for _, wrong in MUTANTS])
def test_wrong_name_is_found(right, wrong):
    """The mutants: a slip in any kind of name."""
    page = PAGE.read_text()
    assert right in page
    assert len(wrong_names(page.replace(right, wrong, 1))) == 1
