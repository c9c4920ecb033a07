"""Every check of log formats has a broken reader that fails it."""

import base64
import pickle
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from harness.files.bounded import read_bytes, reading
from harness.log import Log, LogFacts, in_memory
from harness.log.log import ROWS
from harness_plugins.kit import LOG_CHECKS, check_log_format, violations
from harness_plugins.kit.logs import checks

FIRST = "# toy seed=3"
TYPES = {"env": int, "episode": int, "step": int, "time": int, "terminated": bool, "truncated": bool}
TABLE = 3
"""Rows of a table that the reader gives."""


def example() -> str:
    """Two envs; four episodes, of which the last is unfinished."""
    columns = [
        "env",
        "episode",
        "step",
        "terminated",
        "truncated",
        "time",
        "reward/a",
        "reward/a/x",
        "reward/a/y",
        "behaviour/height",
    ]
    lines = [FIRST, ",".join(columns)]
    for step in range(10):
        for env in (0, 1):
            within, episode = step % (5 + env), step // (5 + env)
            ends = within == 4 + env
            paid = (0.25 * step, -0.5 * env)
            told = (env, episode, within + 1, ends * env, ends * (1 - env), 2 * step + env, sum(paid), *paid, step / 8)
            lines.append(",".join(f"{float(it)!r}" for it in told))
    return "\n".join([*lines, ""])


class Reader:
    """Reads rows of numbers behind two lines of head, three at a time."""

    def recognises(self, path, head):
        return head.startswith(FIRST.encode())

    def read(self, path):
        with reading(path, "toy log"):
            names, table, rest = self.parse(path)
            return self.logs(self.facts(path, table, rest), names)

    def write_example(self, folder):
        path = folder / "toy.log"
        path.write_text(self.text(), encoding="utf-8")
        return path

    def text(self):
        return example()

    def facts(self, path, table, rest):
        note = ("the last row is not whole, and left out",) if rest else ()
        return LogFacts(path=path, format="toy", seed=3, declared=self.declared(table), notes=note)

    def declared(self, table):
        return {}

    def logs(self, facts, names):
        return (Log(facts, names, partial(self.tables, facts.path)),)

    def parse(self, path):
        _, columns, *rows, rest = self.decode(read_bytes(path)).split("\n")
        names = columns.split(",")
        table = np.array([self.numbers(row, names) for row in rows]).reshape(-1, len(names))
        return tuple(names), table, rest

    def numbers(self, row, names):
        found = [float(text) for text in row.split(",")]
        if len(found) != len(names):
            raise ValueError(f"{len(names)} numbers are wanted: {row}")
        return found

    def decode(self, content):
        return content.decode()

    def tables(self, path, chosen):
        with reading(path, "toy log"):
            names, table, _ = self.parse(path)
            for begin in range(0, len(table), TABLE):
                part = table[begin : begin + TABLE].T
                whole = self.changed(dict(zip(names, part, strict=True)), begin)
                typed = {name: values.astype(TYPES.get(name, float)) for name, values in whole.items()}
                yield self.chosen(self.typed(typed), chosen)

    def changed(self, columns, begin):
        return columns

    def typed(self, columns):
        return columns

    def chosen(self, columns, names):
        return {name: columns[name] for name in names}


@dataclass(frozen=True)
class Sound(Reader):
    """Nothing is wrong with it."""


@dataclass
class Thawed(Reader):
    """Its settings can be changed."""


@dataclass(frozen=True)
class SetUpWithASet(Reader):
    """JSON knows no sets."""

    columns: frozenset[int] = frozenset({1})


class WritesOneRow(Sound):
    """Which shows nothing."""

    def text(self):
        return "\n".join([*example().split("\n")[:3], ""])


class TakesEverything(Sound):
    """Every file is its own."""

    def recognises(self, path, head):
        return True


class TakesNothing(Sound):
    """Not even what it wrote."""

    def recognises(self, path, head):
        return False


class SaysAMatch(Sound):
    """It returns something that is true, and not True."""

    def recognises(self, path, head):
        return super().recognises(path, head) or (None if len(head) == 1 else False)


class WantsNamesInUtf8(Sound):
    """A name may hold any bytes."""

    def recognises(self, path, head):
        return bool(path.name.encode()) and super().recognises(path, head)


class LooksAtTheFile(Sound):
    """A link may lead nowhere."""

    def recognises(self, path, head):
        return path.stat().st_size > 0 and super().recognises(path, head)


class TellsASeedAsText(Sound):
    """Seeds are numbers."""

    def facts(self, path, table, rest):
        return replace(super().facts(path, table, rest), seed="3")


class TellsAnotherPath(Sound):
    """Nobody knows what was read."""

    def facts(self, path, table, rest):
        return replace(super().facts(path, table, rest), path=path.parent.parent / "toy.log")

    def logs(self, facts, names):
        return (Log(facts, names, partial(self.tables, facts.path.parent / "example" / "toy.log")),)


class TellsNotesOfTwoLines(Sound):
    """A note is a line of a table."""

    def facts(self, path, table, rest):
        facts = super().facts(path, table, rest)
        return replace(facts, notes=(*facts.notes, "one\ntwo"))


class KnowsAFourthUnit(Sound):
    """Nothing above knows what to do with it."""

    def facts(self, path, table, rest):
        return replace(super().facts(path, table, rest), unit="night")


class NamesNoRuns(Sound):
    """Two trainings of a file have one name."""

    def logs(self, facts, names):
        return super().logs(facts, names) * 2


class BoundsWhatItHasNot(Sound):
    """There is no such measure."""

    def facts(self, path, table, rest):
        return replace(super().facts(path, table, rest), bounds={"speed": (0.0, 1.0)})


class DeclaresTooManyEpisodes(Sound):
    """One more than there are."""

    def declared(self, table):
        return {"episodes": len(np.unique(table[:, :2], axis=0)) + 1}


class CountsStepsOfOneEnv(Sound):
    """There are two."""

    def declared(self, table):
        return {"steps": int((table[:, 0] == 0).sum())}


class LeavesOutEpisodes(Sound):
    """Nobody knows where one ends."""

    def logs(self, facts, names):
        return super().logs(facts, tuple(name for name in names if name != "episode"))


class PaysNothing(Sound):
    """It has neither rewards nor measures."""

    def logs(self, facts, names):
        return super().logs(facts, tuple(name for name in names if "/" not in name))


class KnowsNoTime(Sound):
    """Points that nobody can put on a curve."""

    def logs(self, facts, names):
        return super().logs(replace(facts, unit="point"), tuple(name for name in names if name != "time"))


class CountsInFloats(Sound):
    """Episodes are whole numbers."""

    def typed(self, columns):
        return {name: values.astype(float) if name == "episode" else values for name, values in columns.items()}


class EndsInNumbers(Sound):
    """`~terminated` would be -1 or -2."""

    def typed(self, columns):
        return {name: values.astype(int) if name == "terminated" else values for name, values in columns.items()}


class GivesLists(Sound):
    """A list has no shape."""

    def chosen(self, columns, names):
        return {name: List(columns[name]) for name in names}


class List(list):
    """A list that most of numpy takes for an array."""


class OwnLog(Log):
    """A log that reads on its own account."""

    def pieces(self, columns, rows=ROWS):
        for piece in super().pieces(columns, rows):
            if rows == ROWS or len(piece) == rows:
                yield piece


class LosesTheLastPiece(Sound):
    """It is shorter than the others."""

    def logs(self, facts, names):
        return (OwnLog(facts, names, partial(self.tables, facts.path)),)


class GivesByPosition(Sound):
    """The first column that is asked for is the first of the file."""

    def chosen(self, columns, names):
        kept = [values for name, values in columns.items() if name in names]
        return dict(zip(names, kept, strict=True))


class NeedsAllTerms(Sound):
    """A reward cannot be had without its terms."""

    def chosen(self, columns, names):
        found = super().chosen(columns, names)
        if "reward/a" in found:
            found["reward/a"] = found["reward/a/x"] + found["reward/a/y"]
        return found


class CountsTimeDown(Sound):
    """As a budget that is used up."""

    def changed(self, columns, begin):
        return {**columns, "time": 1000 - columns["time"]}


class CountsEpisodesFromOne(Sound):
    """The first is 0."""

    def changed(self, columns, begin):
        return {**columns, "episode": columns["episode"] + 1}


class CountsStepsOn(Sound):
    """Over the ends of episodes."""

    def changed(self, columns, begin):
        return {**columns, "step": columns["time"] // 2 + 1}


class SkipsSteps(Sound):
    """Every second one is there."""

    def changed(self, columns, begin):
        return {**columns, "step": columns["step"] * 2 - 1}


class EndsNoEpisode(Sound):
    """Another one begins after all."""

    def changed(self, columns, begin):
        return {**columns, "truncated": columns["truncated"] * 0}


class EndsEveryStep(Sound):
    """And the episode goes on."""

    def changed(self, columns, begin):
        return {**columns, "terminated": columns["terminated"] * 0 + 1}


class MeasuresNothing(Sound):
    """A measure is NaN everywhere, and nobody says why."""

    def changed(self, columns, begin):
        return {**columns, "behaviour/height": columns["behaviour/height"] * np.nan}


class PaysNobodyKnowsWhat(Sound):
    """The pay of a step is NaN, and nobody says that the reward failed."""

    def changed(self, columns, begin):
        paid = {name: np.where(columns["step"] == 4, np.nan, columns[name]) for name in ("reward/a", "reward/a/y")}
        return {**columns, **paid}


class MeasuresInfinity(Sound):
    """Failed measures are NaN."""

    def changed(self, columns, begin):
        heights = columns["behaviour/height"]
        return {**columns, "behaviour/height": np.where(heights == 0.5, np.inf, heights)}


class LeavesItsBounds(Sound):
    """It says that heights are at most 1."""

    def facts(self, path, table, rest):
        return replace(super().facts(path, table, rest), bounds={"height": (0.0, 1.0)})


class TermsDoNotSum(Sound):
    """A term is told with another scale."""

    def changed(self, columns, begin):
        return {**columns, "reward/a/y": columns["reward/a/y"] * 2}


class KnowsEveryColumn(Log):
    """What it has not is zero."""

    def rows(self, columns=None):
        names = self.names if columns is None else [*columns]
        found = super().rows([name for name in names if name in self] or self.columns[:1])
        return replace(found, columns={name: found.columns.get(name, np.zeros(len(found))) for name in names})


class FillsWithZeros(Sound):
    """A column that there is not has numbers."""

    def logs(self, facts, names):
        return (KnowsEveryColumn(facts, names, partial(self.tables, facts.path)),)


class WritesAnIndex(Sound):
    """So that the next time is quicker."""

    def read(self, path):
        path.with_suffix(".index").write_text("1")
        return super().read(path)


class WritesItAgain(Sound):
    """With the same bytes, and another date."""

    def read(self, path):
        path.write_bytes(path.read_bytes())
        return super().read(path)


class Greets(Sound):
    """It prints."""

    def read(self, path):
        print("hello")  # noqa: T201
        return super().read(path)


class Evaluates(Sound):
    """A number in the file may be any Python."""

    def facts(self, path, table, rest):
        return replace(super().facts(path, table, rest), seed=eval("1 + 2"))


class Unpickles(Sound):
    """Settings stand in the first line as a pickle."""

    def facts(self, path, table, rest):
        kept = base64.b64encode(pickle.dumps({"seed": 3}))
        return replace(super().facts(path, table, rest), **pickle.loads(base64.b64decode(kept)))


@dataclass(frozen=True)
class LoadsObjects:
    """Arrays of objects are pickles."""

    def recognises(self, path, head):
        return head.startswith(b"PK") and b"returns.npy" in head

    def read(self, path):
        with reading(path, "archive"), path.open("rb") as file, np.load(file, allow_pickle=True) as archive:
            columns = {"reward/recorded": archive["returns"], "length": archive["lengths"]}
            return (in_memory(LogFacts(path=path, format="archive", unit="episode"), columns),)

    def write_example(self, folder):
        np.savez(folder / "archive.npz", returns=np.arange(4.0), lengths=np.arange(1, 5))
        return folder / "archive.npz"


class ReadsHalfRows(Sound):
    """The last row may be cut within a number."""

    def parse(self, path):
        names, table, rest = super().parse(path)
        if rest.count(",") == len(names) - 1:
            table = np.vstack([table, self.numbers(rest, names)])
        return names, table, ""


class SaysNothingOfHalfRows(Sound):
    """They are left out, and nobody says so."""

    def parse(self, path):
        names, table, _ = super().parse(path)
        return names, table, ""


class EndsWhatWasNotEnded(Sound):
    """The last episode of a log that is being written seems to be cut."""

    def parse(self, path):
        names, table, rest = super().parse(path)
        if rest:
            table[-1:, names.index("truncated")] = 1
        return names, table, rest


class Stumbles(Sound):
    """It lets an error of its own through."""

    def read(self, path):
        try:
            names, table, rest = self.parse(path)
        except ValueError as error:
            raise KeyError("columns") from error
        return self.logs(self.facts(path, table, rest), names)


class LeavesOutOtherBytes(Sound):
    """Digits go with them."""

    def decode(self, content):
        return content.decode(errors="ignore")


class LeavesOutWrongRows(Sound):
    """Without a word."""

    def parse(self, path):
        _, columns, *rows, rest = read_bytes(path).decode(errors="replace").split("\n")
        names = columns.split(",")
        if names != example().split("\n")[1].split(","):
            raise ValueError("no columns")
        found = []
        for row in rows:
            try:
                found.append(self.numbers(row, names))
            except ValueError:
                continue
        return tuple(names), np.array(found).reshape(-1, len(names)), rest


class ReusesItsBuffer(Sound):
    """Each table stands where the one before it stood."""

    def tables(self, path, chosen):
        buffers = {}
        for table in super().tables(path, chosen):
            for name, values in table.items():
                buffer = buffers.setdefault(name, values.copy())
                buffer[: len(values)] = values
            yield {name: buffers[name][: len(values)] for name, values in table.items()}


class ReadsOnce(Sound):
    """A second pass has no rows."""

    def logs(self, facts, names):
        tables = iter([*self.tables(facts.path, names)])
        return (Log(facts, names, lambda chosen: ({name: table[name] for name in chosen} for table in tables)),)


@dataclass(frozen=True)
class TellsAnythingAtAll(Sound):
    """It measures anew each time."""

    def changed(self, columns, begin):
        return {**columns, "behaviour/height": np.random.default_rng().random(len(columns["time"]))}


MUTANTS = {
    Thawed: checks.settings_are_frozen,
    SetUpWithASet: checks.settings_survive_json,
    WritesOneRow: checks.the_example_is_a_log,
    TakesEverything: checks.the_example_is_recognised,
    TakesNothing: checks.the_example_is_recognised,
    SaysAMatch: checks.recognising_raises_nothing,
    WantsNamesInUtf8: checks.recognising_raises_nothing,
    LooksAtTheFile: checks.recognising_raises_nothing,
    TellsASeedAsText: checks.facts_are_sensible,
    TellsAnotherPath: checks.facts_are_sensible,
    TellsNotesOfTwoLines: checks.facts_are_sensible,
    NamesNoRuns: checks.facts_are_sensible,
    DeclaresTooManyEpisodes: checks.declared_totals_hold,
    CountsStepsOfOneEnv: checks.declared_totals_hold,
    LeavesOutEpisodes: checks.standard_columns_are_there,
    PaysNothing: checks.standard_columns_are_there,
    KnowsNoTime: checks.standard_columns_are_there,
    CountsInFloats: checks.columns_hold_what_their_names_say,
    EndsInNumbers: checks.columns_hold_what_their_names_say,
    GivesLists: checks.columns_hold_what_their_names_say,
    LosesTheLastPiece: checks.pieces_make_the_whole,
    GivesByPosition: checks.columns_can_be_chosen,
    NeedsAllTerms: checks.columns_can_be_chosen,
    CountsTimeDown: checks.rows_are_in_order,
    CountsEpisodesFromOne: checks.rows_are_in_order,
    CountsStepsOn: checks.rows_are_in_order,
    SkipsSteps: checks.rows_are_in_order,
    EndsNoEpisode: checks.rows_are_in_order,
    EndsEveryStep: checks.rows_are_in_order,
    MeasuresNothing: checks.values_are_finite,
    PaysNobodyKnowsWhat: checks.values_are_finite,
    MeasuresInfinity: checks.values_are_finite,
    LeavesItsBounds: checks.values_are_finite,
    TermsDoNotSum: checks.terms_make_their_reward,
    FillsWithZeros: checks.unknown_columns_are_refused,
    WritesAnIndex: checks.the_file_is_left_alone,
    WritesItAgain: checks.the_file_is_left_alone,
    Greets: checks.nothing_is_printed,
    Evaluates: checks.reading_runs_no_code,
    Unpickles: checks.reading_runs_no_code,
    LoadsObjects: checks.reading_runs_no_code,
    ReadsHalfRows: checks.a_cut_file_gives_no_other_numbers,
    SaysNothingOfHalfRows: checks.a_cut_file_gives_no_other_numbers,
    EndsWhatWasNotEnded: checks.a_cut_file_gives_no_other_numbers,
    LeavesOutOtherBytes: checks.a_changed_file_gives_no_other_numbers,
    LeavesOutWrongRows: checks.a_changed_file_gives_no_other_numbers,
}
COARSE_MUTANTS = {
    KnowsAFourthUnit: checks.facts_are_sensible,
    BoundsWhatItHasNot: checks.facts_are_sensible,
    ReadsOnce: checks.it_can_be_read_again,
    TellsAnythingAtAll: checks.it_can_be_read_again,
    ReusesItsBuffer: checks.pieces_make_the_whole,
    Stumbles: checks.a_cut_file_gives_no_other_numbers,
}
"""Readers that are wrong in a way that several checks see."""


def failing(mutant: type, folder: Path) -> list[str]:
    """Names of the checks that a mutant fails."""
    found = []
    for check in LOG_CHECKS:
        place = folder / check.name
        place.mkdir()
        found += [violation.check for violation in violations([check], mutant(), place)]
    return found


def test_mutant_fails_one_check(tmp_path_factory: pytest.TempPathFactory, subtests: pytest.Subtests):
    """A reader that is broken in one way fails the check of that fact, and no other."""
    for mutant, check in MUTANTS.items():
        with subtests.test(mutant=mutant, check=check):
            tmp_path = tmp_path_factory.mktemp("case")
            assert failing(mutant, tmp_path) == [check.name]


def test_coarse_mutant_fails_a_check(tmp_path_factory: pytest.TempPathFactory, subtests: pytest.Subtests):
    """A reader that is broken from the ground up fails the check that says what is wrong, and others."""
    for mutant, check in COARSE_MUTANTS.items():
        with subtests.test(mutant=mutant, check=check):
            tmp_path = tmp_path_factory.mktemp("case")
            assert check.name in failing(mutant, tmp_path)


def test_every_check_has_a_mutant():
    """No check is without a reader that fails it."""
    assert {*MUTANTS.values(), *COARSE_MUTANTS.values()} == set(LOG_CHECKS)


def test_the_mutants_are_made_of_a_sound_reader(tmp_path: Path):
    """What the mutants are made of fails nothing."""
    check_log_format(Sound(), tmp_path)
