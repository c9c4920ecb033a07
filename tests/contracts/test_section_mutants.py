"""Every check of a section catches the mistake that it is there for."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from harness.errors import SchemaError
from harness.record.manifest import read_manifest
from harness.results import Results
from harness_plugins.kit import SECTION_CHECKS, check_section, sections, violations
from harness_plugins.kit.sections import SECTION_WARNINGS
from tests.report.conftest import build_results

HTML = '<h3 id="notes">Notes</h3>\n<p>1 &lt; 2<br>done</p>\n<svg><path d="M0 0"/></svg>'


@dataclass(frozen=True)
class Shown:
    """What a section says; a mutant's differs in one thing."""

    html_text: str = HTML
    style: str = ".notes { background: url(data:image/gif;base64,R0lGODlh); }"
    json: Any = None
    printed: str = "one note"

    def to_json(self):
        return {"notes": 1.5} if self.json is None else self.json

    def table(self):
        return self.printed

    def html(self):
        return self.html_text


@dataclass(frozen=True)
class Sound:
    """It has a folder of its own beside those of the cells: nothing is wrong with it."""

    what = "a note of a cell"
    shown = Shown()

    def ending(self, folder):
        return read_manifest(folder)

    def show(self, results: Results):
        return self.shown if (results.folder / "notes").exists() else None


@dataclass
class Thawed:
    """Its settings can be changed while it is asked."""

    what = Sound.what
    shown = Sound.shown
    ending = Sound.ending
    show = Sound.show


@dataclass(frozen=True)
class SetUpWithASet(Sound):
    """JSON knows no sets."""

    zones: frozenset[int] = frozenset({1})


class HasNoArticle(Sound):
    """No sentence can be made of it."""

    what = "note"


class HasAFullStop(Sound):
    """Nor of this."""

    what = "a note of a cell."


class TakesAnyManifest(Sound):
    """Whatever it cannot read was not done."""

    def ending(self, folder):
        try:
            return read_manifest(folder)
        except SchemaError:
            return None


class LetsErrorsThrough(Sound):
    """It reads the file as it is."""

    def ending(self, folder):
        return (folder / "manifest.json").read_text(encoding="utf-8")


class AlwaysSpeaks(Sound):
    """It says that there is nothing to say, of cells that are done."""

    def show(self, results):
        return self.shown if results.done_cells else None


class NeverSpeaks(Sound):
    """It looks into another folder."""

    def show(self, results):
        return None


class CountsToInfinity(Sound):
    """What JSON has no number for."""

    shown = Shown(json={"notes": float("inf")})


class TellsAPath(Sound):
    """What JSON has no word for."""

    shown = Shown(json={"notes": Path("notes")})


class TellsAList(Sound):
    """Nothing has a name."""

    shown = Shown(json=[1.5])


class PrintsNothing(Sound):
    """An empty table."""

    shown = Shown(printed=" ")


class PrintsBadMarkup(Sound):
    """Rich cannot read it."""

    shown = Shown(printed="[/nothing]")


class BeginsWithText(Sound):
    """The heading is behind it."""

    shown = Shown("Notes" + HTML)


class BeginsWithAnotherHeading(Sound):
    """Which is one of the page's own."""

    shown = Shown("<h2>Notes</h2>")


class LeavesAnElementOpen(Sound):
    """The rest of the page is in it."""

    shown = Shown(HTML + "<div>")


class EndsInDisorder(Sound):
    """One in another."""

    shown = Shown(HTML + "<p><b>one</p></b>")


class EndsThePage(Sound):
    """It ends what it did not begin."""

    shown = Shown(HTML + "</section>")


class EndsADivAtOnce(Sound):
    """To a browser it goes on."""

    shown = Shown(HTML + "<div/>")


class HasAScript(Sound):
    """It runs."""

    shown = Shown(HTML + "<script>alert(1)</script>")


class ListensToClicks(Sound):
    """It runs when it is clicked."""

    shown = Shown(HTML + '<p onclick="alert(1)">one</p>')


class LinksToAScript(Sound):
    """So does this."""

    shown = Shown(HTML + '<a href="javascript:alert(1)">one</a>')


class LoadsAPicture(Sound):
    """From the network."""

    shown = Shown(HTML + '<img alt="one" src="https://example.org/one.png">')


class LoadsABackground(Sound):
    """By its style."""

    shown = Shown(style=".notes { background: url('//example.org/one.png'); }")


class LoadsAFontInAnElement(Sound):
    """By a style in the HTML."""

    shown = Shown(HTML + "<style>@import 'fonts.css';</style>")


class EndsItsStyle(Sound):
    """The page goes on as it likes."""

    shown = Shown(style="</style><b>one</b>")


MUTANTS = {
    Thawed: sections.settings_are_frozen,
    SetUpWithASet: sections.settings_survive_json,
    HasNoArticle: sections.what_is_a_phrase,
    HasAFullStop: sections.what_is_a_phrase,
    TakesAnyManifest: sections.damaged_manifests_are_refused,
    LetsErrorsThrough: sections.damaged_manifests_are_refused,
    AlwaysSpeaks: sections.nothing_is_said_of_nothing,
    NeverSpeaks: sections.something_is_said_of_its_folders,
    CountsToInfinity: sections.json_is_plain_and_finite,
    TellsAPath: sections.json_is_plain_and_finite,
    TellsAList: sections.json_is_plain_and_finite,
    PrintsNothing: sections.the_table_can_be_printed,
    PrintsBadMarkup: sections.the_table_can_be_printed,
    BeginsWithText: sections.html_is_well_formed,
    BeginsWithAnotherHeading: sections.html_is_well_formed,
    LeavesAnElementOpen: sections.html_is_well_formed,
    EndsInDisorder: sections.html_is_well_formed,
    EndsThePage: sections.html_is_well_formed,
    EndsADivAtOnce: sections.html_is_well_formed,
    HasAScript: sections.html_loads_and_runs_nothing,
    ListensToClicks: sections.html_loads_and_runs_nothing,
    LinksToAScript: sections.html_loads_and_runs_nothing,
    LoadsAPicture: sections.html_loads_and_runs_nothing,
    LoadsABackground: sections.html_loads_and_runs_nothing,
    LoadsAFontInAnElement: sections.html_loads_and_runs_nothing,
    EndsItsStyle: sections.html_loads_and_runs_nothing,
}


@pytest.fixture(scope="module")
def experiment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An experiment with the folder of a section."""
    folder = tmp_path_factory.mktemp("experiment")
    build_results(folder)
    (folder / "notes").mkdir()
    return folder


def failing(section: Any, folder: Path) -> list[str]:
    """Names of the checks that a section fails."""
    return [violation.check for violation in violations((*SECTION_CHECKS, *SECTION_WARNINGS), section, folder)]


def test_mutant_fails_one_check(experiment: Path, subtests: pytest.Subtests):
    """A section that is broken in one way fails the check of that fact, and no other."""
    for mutant, check in MUTANTS.items():
        with subtests.test(mutant=mutant, check=check):
            assert failing(mutant(), experiment) == [check.name]


def test_every_check_has_a_mutant():
    """No check is without a section that fails it alone."""
    assert set(MUTANTS.values()) == set(SECTION_CHECKS)


def test_the_mutants_are_made_of_a_sound_section(experiment: Path):
    """What the mutants are made of fails nothing, with an experiment and without."""
    check_section(Sound(), experiment)
    check_section(Sound())


def test_what_was_not_tried_is_told(tmp_path: Path):
    """Without an experiment nothing of what a section shows is known, and a warning says so."""
    assert failing(Sound(), tmp_path) == ["section-untried"]
    assert failing(HasAScript(), tmp_path) == ["section-untried"]
