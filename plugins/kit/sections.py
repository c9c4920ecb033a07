"""What a section of the report must satisfy.

Each check takes the section and a folder: of an experiment that its command has filled a folder of, or an empty one.
What is shown of an experiment is looked at in the first alone.
"""

import io
import json
import re
import tempfile
from collections.abc import Mapping
from html.parser import HTMLParser
from pathlib import Path

from rich.console import Console

from harness import load_results
from harness.authoring import run_job
from harness.authoring.commands import MANIFEST, PLAN, Store, check_experiment, expand, load_registry
from harness.errors import SchemaError
from harness.executor import Job
from harness.section import Section, Shown

from .contract import (
    Check,
    check,
    raise_first,
    raise_first_in_folders,
    require,
    settings_are_frozen,
    settings_survive_json,
)

PHRASE = re.compile(r"(a|an|the) \S.*[^\s.]")
DAMAGED = {
    "empty": b"",
    "cut": b'{"format": 1',
    "no UTF-8": b"\xff" * 8,
    "a list": b"[]",
    "without a key": b"{}",
    "of a newer version": b'{"format": 1000000}',
}
"""Manifests that nobody can read."""
VOID = {"area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "source", "track", "wbr"}
"""Elements of HTML that have no end."""
FOREIGN = {"svg", "math"}
"""In these an element may end itself, ``<path/>``."""
SCRIPTED = {"script", "iframe", "object", "embed", "base", "meta", "link"}
"""Elements that run something, load something, or change the page around them."""
LOADED = {"src", "srcset", "data", "poster", "background", "xlink:href"}
"""Attributes whose address is fetched without a click; of whatever is no link to click also ``href``."""
FETCHES = re.compile(r"@import|url\(\s*['\"]?(?!data:|#)", re.IGNORECASE)
"""Rules of a style sheet that load something."""
NARROW = 60
"""Columns of a terminal."""


def check_section(section: Section, folder: Path | None = None) -> None:
    """Run all `SECTION_CHECKS`.

    Args:
        section: To be checked.
        folder: Of an experiment that its command has filled a folder of; if None, what it shows is not looked at.

    Raises:
        ContractViolation: At the first check that fails.
    """
    if folder is None:
        raise_first_in_folders(SECTION_CHECKS, section, None)
    else:
        raise_first(SECTION_CHECKS, section, folder)


@check("section-what")
def what_is_a_phrase(section: Section, folder: Path) -> None:
    """`what` is a phrase with an article and no full stop, "an evaluation elsewhere": sentences are made of it."""
    what = section.what
    require(isinstance(what, str) and PHRASE.fullmatch(what), f"what is {what!r}, no phrase with an article")


@check("section-ending")
def damaged_manifests_are_refused(section: Section, folder: Path) -> None:
    """`ending` raises SchemaError for a manifest that is empty, cut, something else or of a newer version."""
    with tempfile.TemporaryDirectory() as place:
        for how, content in DAMAGED.items():
            (Path(place) / MANIFEST).write_bytes(content)
            try:
                ending = section.ending(Path(place))
            except SchemaError:
                continue
            raise AssertionError(f"of a manifest that is {how}, ending gives {ending!r}")


@check("section-silent")
def nothing_is_said_of_nothing(section: Section, folder: Path) -> None:
    """`show` gives None of an experiment that the section's command has added nothing to."""
    with tempfile.TemporaryDirectory() as place:
        experiment = Path(place) / "experiment"
        _run_experiment(experiment)
        shown = section.show(load_results(experiment))
        require(shown is None, f"of an experiment without its folders, show gives {shown!r}")


@check("section-shows")
def something_is_said_of_its_folders(section: Section, folder: Path) -> None:
    """`show` gives something of an experiment that the section's command has filled a folder of."""
    require(not _is_experiment(folder) or _shown(section, folder), f"show gives nothing of {folder}")


@check("section-json")
def json_is_plain_and_finite(section: Section, folder: Path) -> None:
    """`to_json` gives a mapping that can be written as JSON, with finite numbers only."""
    shown = _shown(section, folder)
    values = shown.to_json() if shown else {}
    require(isinstance(values, Mapping), f"to_json gives {type(values).__name__}, no mapping")
    try:
        json.dumps(values, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise AssertionError(f"what to_json gives is no plain JSON: {error}") from error


@check("section-table")
def the_table_can_be_printed(section: Section, folder: Path) -> None:
    """`table` gives what rich prints on a narrow terminal, and it is not empty."""
    shown = _shown(section, folder)
    if shown:
        console = Console(file=io.StringIO(), width=NARROW)
        with console.capture() as printed:
            console.print(shown.table())
        require(printed.get().strip(), f"nothing is printed in {NARROW} columns")


@check("section-html")
def html_is_well_formed(section: Section, folder: Path) -> None:
    """`html` begins with an ``h3``, and each of its elements is ended where it began."""
    elements = _elements(_shown(section, folder))
    if elements:
        require(elements.first == "h3", f"the HTML begins with {elements.first or 'text'}, not with h3")
        require(not elements.faults and not elements.open, "; ".join([*elements.faults, *_unended(elements.open)]))


@check("section-closed")
def html_loads_and_runs_nothing(section: Section, folder: Path) -> None:
    """`html` and `style` have no script and load nothing: the page is one file that can be read anywhere."""
    shown = _shown(section, folder)
    elements = _elements(shown)
    if shown and elements:
        require(not elements.active, f"the HTML has {', '.join(elements.active)}")
        fetched = [text.strip() for text in (shown.style, *elements.styles) if FETCHES.search(text)]
        require(not fetched, f"a style loads something: {fetched}")
        require("<" not in shown.style, "the style has '<', which may end it on the page")


SECTION_CHECKS: tuple[Check, ...] = (
    settings_are_frozen,
    settings_survive_json,
    what_is_a_phrase,
    damaged_manifests_are_refused,
    nothing_is_said_of_nothing,
    something_is_said_of_its_folders,
    json_is_plain_and_finite,
    the_table_can_be_printed,
    html_is_well_formed,
    html_loads_and_runs_nothing,
)


@check("section-untried", "warning")
def what_it_shows_was_tried(section: Section, folder: Path) -> None:
    """There is an experiment to look at what the section shows of it."""
    require(
        _is_experiment(folder),
        "what it shows was not tried: in a test, give check_section the folder of an experiment that it has a part in",
    )


SECTION_WARNINGS: tuple[Check, ...] = (what_it_shows_was_tried,)


class _Elements(HTMLParser):
    """The elements of a part of a page.

    Attributes:
        first: The name of what stands first; empty if that is text.
        open: Names of the elements that are not ended yet.
        faults: What is not well-formed.
        active: What runs or loads something.
        styles: The texts of styles.
    """

    def __init__(self, text: str) -> None:
        super().__init__()
        self.first: str | None = None
        self.open: list[str] = []
        self.faults: list[str] = []
        self.active: list[str] = []
        self.styles: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._look_at(tag, attrs)
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._look_at(tag, attrs)
        if tag not in VOID and not FOREIGN & {tag, *self.open}:
            self.faults.append(f"<{tag}/> does not end itself")

    def handle_endtag(self, tag: str) -> None:
        if self.open[-1:] == [tag]:
            self.open.pop()
        else:
            self.faults.append(f"</{tag}> ends {self.open[-1] if self.open else 'nothing'}")

    def handle_data(self, data: str) -> None:
        if data.strip() and self.first is None:
            self.first = ""
        if self.open[-1:] == ["style"]:
            self.styles.append(data)

    def _look_at(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.first = tag if self.first is None else self.first
        self.active += [f"<{tag}>"] * (tag in SCRIPTED)
        for name, value in attrs:
            address = (value or "").strip().lower()
            is_loaded = name in LOADED or (name == "href" and tag != "a")
            if (
                name.startswith("on")
                or address.startswith("javascript:")
                or (is_loaded and not address.startswith(("data:", "#")))
            ):
                self.active.append(f'{name}="{value}"')
            self.styles += [value or ""] * (name == "style")


def _unended(names: list[str]) -> list[str]:
    return [f"<{name}> is not ended" for name in names]


def _elements(shown: Shown | None) -> _Elements | None:
    return _Elements(shown.html()) if shown else None


def _is_experiment(folder: Path) -> bool:
    return (folder / PLAN).is_file()


def _shown(section: Section, folder: Path) -> Shown | None:
    """What it shows of the experiment in `folder`; None without one."""
    return section.show(load_results(folder)) if _is_experiment(folder) else None


def _run_experiment(folder: Path) -> None:
    """A small experiment, whose cells are done in this process."""
    names = {"sim": "kinematic", "algo": "random", "baseline": "sparse", "reward": []}
    settings = {**names, "seeds": [0], "steps": 32, "evaluation_episodes": 1}
    plan = expand(check_experiment(settings, "the contract kit"), load_registry())
    store = Store.create(folder, plan)
    for cell in plan.cells:
        run_job(Job(cell, store.cell_folder(cell)))
