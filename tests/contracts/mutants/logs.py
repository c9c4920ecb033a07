"""Broken readers of logs: of rows of numbers behind two lines of head."""

import pickle
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from harness.files import read_bytes, reading
from harness.log import Log, LogFacts, in_memory
from harness.log.log import ROWS

from . import mutant

FIRST = "# toy seed=3"
COLUMNS = "env,episode,step,terminated,truncated,time,reward/a,reward/a/x,reward/a/y,behaviour/height"
TYPES = {"env": int, "episode": int, "step": int, "time": int, "terminated": bool, "truncated": bool}
TABLE = 3
"""Rows of a table that the reader gives."""


def example():
    """Two envs; four episodes, of which the last is unfinished."""
    lines = [FIRST, COLUMNS]
    for step in range(10):
        for env in (0, 1):
            within, episode = step % (5 + env), step // (5 + env)
            ends = within == 4 + env
            paid = (0.25 * step, -0.5 * env)
            told = (env, episode, within + 1, ends * env, ends * (1 - env), 2 * step + env, sum(paid), *paid, step / 8)
            lines.append(",".join(f"{float(it)!r}" for it in told))
    return "\n".join([*lines, ""])


@dataclass(frozen=True)
class Reader:
    """Three rows at a time."""

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
        return LogFacts(path=path, format="toy", seed=3, notes=note)

    def logs(self, facts, names):
        return (Log(facts, names, partial(self.tables, facts.path)),)

    def parse(self, path):
        _, columns, *rows, rest = self.decode(read_bytes(path)).split("\n")
        names = columns.split(",")
        table = np.array([numbers(row, names) for row in rows]).reshape(-1, len(names))
        return tuple(names), table, rest

    def decode(self, content):
        return content.decode()

    def tables(self, path, chosen):
        with reading(path, "toy log"):
            names, table, _ = self.parse(path)
            for begin in range(0, len(table), TABLE):
                whole = self.changed(dict(zip(names, table[begin : begin + TABLE].T, strict=True)))
                typed = {name: values.astype(self.types.get(name, float)) for name, values in whole.items()}
                yield self.chosen(typed, chosen)

    types = TYPES

    def changed(self, columns):
        return columns

    def chosen(self, columns, names):
        return {name: columns[name] for name in names}


def numbers(row, names):
    """Of a row, one for each name."""
    found = [float(text) for text in row.split(",")]
    if len(found) != len(names):
        raise ValueError(f"{len(names)} numbers are wanted: {row}")
    return found


def reads(**changed):
    """A reader with other methods."""
    return mutant(Reader, **changed)


def says(**facts):
    """A reader of other facts; those that are functions are called when it reads."""
    return reads(
        facts=lambda self, *read: replace(
            Reader.facts(self, *read), **{name: it() if callable(it) else it for name, it in facts.items()}
        )
    )


def lists(keep, **facts):
    """A reader that has not all columns."""
    return reads(
        logs=lambda self, told, names: Reader.logs(self, replace(told, **facts), tuple(it for it in names if keep(it)))
    )


def holds(**change):
    """A reader of other numbers: what makes a column of all columns."""
    named = {name.replace("__", "/"): make for name, make in change.items()}
    return reads(changed=lambda self, of: {**of, **{name: make(of) for name, make in named.items()}})


def as_log(kind):
    """A reader that gives a log of another class."""
    return reads(logs=lambda self, facts, names: (kind(facts, names, partial(self.tables, facts.path)),))


def elsewhere(self, facts, names):
    """Nobody knows what was read."""
    told = replace(facts, path=facts.path.parent.parent / "toy.log")
    return (Log(told, names, partial(self.tables, facts.path)),)


class List(list):
    """A list that most of numpy takes for an array."""


class LosesTheLastPiece(Log):
    """It is shorter than the others."""

    def pieces(self, columns, rows=ROWS):
        for piece in super().pieces(columns, rows):
            if rows == ROWS or len(piece) == rows:
                yield piece


class KnowsEveryColumn(Log):
    """What it has not is zero."""

    def rows(self, columns=None):
        names = self.names if columns is None else [*columns]
        found = super().rows([name for name in names if name in self] or self.columns[:1])
        return replace(found, columns={name: found.columns.get(name, np.zeros(len(found))) for name in names})


def needs_all_terms(self, columns, names):
    """A reward cannot be had without its terms."""
    found = Reader.chosen(self, columns, names)
    if "reward/a" in found:
        found["reward/a"] = found["reward/a/x"] + found["reward/a/y"]
    return found


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


def half_rows(self, path):
    """The last row may be cut within a number."""
    names, table, rest = Reader.parse(self, path)
    if rest.count(",") == len(names) - 1:
        table = np.vstack([table, numbers(rest, names)])
    return names, table, ""


def ended(self, path):
    """The last episode of a log that is being written seems to be cut."""
    names, table, rest = Reader.parse(self, path)
    if rest:
        table[-1:, names.index("truncated")] = 1
    return names, table, rest


def stumbles(self, path):
    """It lets an error of its own through."""
    try:
        names, table, rest = self.parse(path)
    except ValueError as error:
        raise KeyError("columns") from error
    return self.logs(self.facts(path, table, rest), names)


def without_wrong_rows(self, path):
    """They are left out, without a word."""
    _, columns, *rows, rest = read_bytes(path).decode(errors="replace").split("\n")
    if columns != COLUMNS:
        raise ValueError("no columns")
    names, found = columns.split(","), []
    for row in rows:
        try:
            found.append(numbers(row, names))
        except ValueError:
            continue
    return tuple(names), np.array(found).reshape(-1, len(names)), rest


def into_one_buffer(self, path, chosen):
    """Each table stands where the one before it stood."""
    buffers = {}
    for table in Reader.tables(self, path, chosen):
        for name, values in table.items():
            buffer = buffers.setdefault(name, values.copy())
            buffer[: len(values)] = values
        yield {name: buffers[name][: len(values)] for name, values in table.items()}


def once(self, facts, names):
    """A second pass has no rows."""
    tables = iter([*self.tables(facts.path, names)])
    return (Log(facts, names, lambda chosen: ({name: table[name] for name in chosen} for table in tables)),)


def lost(name):
    """A column without a number at the fourth step."""
    return lambda of: np.where(of["step"] == 4, np.nan, of[name])


SOUND = (Reader(),)
MUTANTS = {
    "writes one row": ("log-example", reads(text=lambda self: "\n".join([*example().split("\n")[:3], ""]))),
    "takes everything": ("log-recognises", reads(recognises=lambda *_: True), "it takes a file of 0"),
    "takes nothing": ("log-recognises", reads(recognises=lambda *_: False), "it wrote itself"),
    "says a match": (
        "log-harmless",
        reads(
            recognises=lambda self, path, head: (
                Reader.recognises(self, path, head) or (None if len(head) == 1 else False)
            )
        ),
        "recognises returned None",
    ),
    "wants names in UTF-8": (
        "log-harmless",
        reads(recognises=lambda self, path, head: bool(path.name.encode())),
        "raised UnicodeEncodeError",
    ),
    "looks at the file": (
        "log-harmless",
        reads(recognises=lambda self, path, head: path.stat().st_size < 0),
        "raised FileNotFoundError",
    ),
    "a seed as text": ("log-facts", says(seed="3"), "facts.seed is '3'"),
    "another path": ("log-facts", reads(logs=elsewhere), "facts.path is"),
    "a note of two lines": ("log-facts", says(notes=("one\ntwo",)), "one line"),
    "a fourth unit": ("log-facts", says(unit="night"), "facts.unit is 'night'"),
    "two of one name": (
        "log-facts",
        reads(logs=lambda self, facts, names: Reader.logs(self, facts, names) * 2),
        "are called ['', '']",
    ),
    "bounds of what it has not": (
        "log-facts",
        says(bounds={"speed": (0.0, 1.0)}),
        "facts tell of the measure speed",
    ),
    "too many episodes": (
        "log-declared",
        says(declared={"episodes": 5}),
        "declares 5 episodes, and its rows have 4",
    ),
    "steps of one env": (
        "log-declared",
        says(declared={"steps": 10}),
        "declares 10 steps, and its rows have 20",
    ),
    "no episodes": ("log-standard-columns", lists(lambda name: name != "episode"), "no column episode"),
    "no pay": ("log-standard-columns", lists(lambda name: "/" not in name), "neither a reward/NAME"),
    "no time": (
        "log-standard-columns",
        lists(lambda name: name != "time", unit="point"),
        "no column time or iteration",
    ),
    "counts in floats": ("log-types", reads(types={**TYPES, "episode": float}), "episode holds float64"),
    "ends in numbers": ("log-types", reads(types={**TYPES, "terminated": int}), "terminated holds int64"),
    "lists": (
        "log-types",
        reads(chosen=lambda self, of, names: {name: List(of[name]) for name in names}),
        "no numpy array",
    ),
    "loses the last piece": ("log-pieces", as_log(LosesTheLastPiece), "in pieces of 7 there are 14 rows"),
    "reuses its buffer": ("log-pieces", reads(tables=into_one_buffer), "rows 0 to 1, in pieces of 1"),
    "gives by position": (
        "log-columns",
        reads(chosen=lambda self, of, names: dict(zip(names, [of[name] for name in of if name in names], strict=True))),
        "reversed: the column",
    ),
    "needs all terms": ("log-columns", reads(chosen=needs_all_terms), "raised SchemaError"),
    "reads once": ("log-again", reads(logs=once), "in a second pass there are 0 rows"),
    "tells anything at all": (
        "log-again",
        holds(behaviour__height=lambda of: np.random.default_rng().random(len(of["time"]))),
        "in a second pass",
    ),
    "time goes down": ("log-order", holds(time=lambda of: 1000 - of["time"]), "the time falls"),
    "episodes from one": ("log-order", holds(episode=lambda of: of["episode"] + 1), "begin with 1, not 0"),
    "steps go on": ("log-order", holds(step=lambda of: of["time"] // 2 + 1), "the steps of an episode begin with"),
    "skips steps": ("log-order", holds(step=lambda of: of["step"] * 2 - 1), "its steps do not count up by one"),
    "ends no episode": ("log-order", holds(truncated=lambda of: of["truncated"] * 0), "and another begins"),
    "ends every step": ("log-order", holds(terminated=lambda of: of["terminated"] * 0 + 1), "goes on after a row"),
    "measures nothing": (
        "log-finite",
        holds(behaviour__height=lambda of: of["behaviour/height"] * np.nan),
        "height is NaN, and facts.failed",
    ),
    "pays nobody knows what": (
        "log-finite",
        holds(reward__a=lost("reward/a"), reward__a__y=lost("reward/a/y")),
        "reward/a is NaN, and facts.failed",
    ),
    "measures infinity": (
        "log-finite",
        holds(behaviour__height=lambda of: np.where(of["step"] == 5, np.inf, of["behaviour/height"])),
        "is beyond 1e+150",
    ),
    "leaves its bounds": (
        "log-finite",
        says(bounds={"height": (0.0, 1.0)}),
        "leaves its bounds",
    ),
    "terms do not sum": ("log-terms", holds(reward__a__y=lambda of: of["reward/a/y"] * 2)),
    "fills with zeros": ("log-unknown", as_log(KnowsEveryColumn)),
    "writes an index": (
        "log-left-alone",
        reads(read=lambda self, path: path.with_suffix(".index").write_text("1") and Reader.read(self, path)),
        "reading wrote example/toy.index",
    ),
    "writes it again": (
        "log-left-alone",
        reads(read=lambda self, path: path.write_bytes(path.read_bytes()) and Reader.read(self, path)),
        "reading changed example/toy.log",
    ),
    "greets": ("log-silent", reads(read=lambda self, path: print("hello") or Reader.read(self, path))),  # noqa: T201
    "evaluates": ("log-no-code", says(seed=lambda: eval("1 + 2")), "it read with eval"),
    "unpickles": ("log-no-code", says(seed=lambda: pickle.loads(pickle.dumps(3))), "it read with pickle.loads"),
    "loads objects": ("log-no-code", LoadsObjects(), "it read with numpy.load(allow_pickle=True)"),
    "reads half rows": ("log-cut", reads(parse=half_rows), "cut to 124 bytes, rows are missing"),
    "says nothing of half rows": (
        "log-cut",
        reads(parse=lambda self, path: (*Reader.parse(self, path)[:2], "")),
        "cut to 124 bytes, rows are missing",
    ),
    "ends what was not ended": ("log-cut", reads(parse=ended), "the column truncated begins with"),
    "stumbles": ("log-cut", reads(read=stumbles), "it raised KeyError: 'columns'"),
    "leaves out other bytes": (
        "log-changed",
        reads(decode=lambda self, content: content.decode(errors="ignore")),
        "there is a column ed",
    ),
    "leaves out wrong rows": ("log-changed", reads(parse=without_wrong_rows), "the column env begins with"),
}
