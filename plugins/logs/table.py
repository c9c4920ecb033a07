"""Any table of a training, or of several: one reader, whoever wrote it.

A row is an episode, or a point of a curve. Columns are found by their names, see `curves`. A column of text says of
which training a row is, or is asked about: none is passed over without a word.
"""

import json
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np

from harness import Float
from harness.errors import AskedError, SchemaError, UsageError, one_line
from harness.files import parse_json, read_bytes
from harness.log import Log, LogFacts, in_memory, require_columns
from harness.log.text_table import NOTHING, TRUTH, TextTable, first_rows, head_of, parse_table, read_text
from harness.score.row_meaning import (
    ENV,
    INDEX,
    SEED,
    fault_of_episodes,
    is_of_episodes,
    labels_of,
    names_a_run,
    split,
    why_no_steps,
)

from ..curves import (
    OF_ALL,
    ROLES,
    TIME,
    VALUES,
    Chosen,
    Roles,
    Series,
    cleanrl_run,
    column_of,
    curve,
    is_history,
    plain,
    points,
)
from ..zoo_settings import whole, zoo_settings

MONITOR = ("r", "l", "t")
"""Return, length and seconds since the file was begun: how every file of stable-baselines3's Monitor begins."""
BARE_ROW = re.compile(r"-?\d+(\.\d+)?(e[+-]?\d+)?,\d+,\d+(\.\d+)?(e[+-]?\d+)?(,|\s*$)")
"""The first line of a file that Monitor was to append to, and that was not there: it writes no header then."""
MONITORED = re.compile(r"(.*\.)?monitor\.csv")
NAMELESS = "column "
PAY = re.compile(r"rew(ard)?|return|\bpay", re.IGNORECASE)
"""In the name of a column that is pay, and so no measure that no reward enters."""
EXPORT = ("Wall time", "Step", "Value")
"""The header of a curve that was exported from TensorBoard's page."""
EXPORTED = re.compile(r"(?P<before>run[-_](?P<run>.+)-tag-)(?P<tag>.+)\.csv")
BETWEEN, ENDS = " - ", re.compile(r"__(MIN|MAX)$")
"""Stands between a run and its curve in a chart of Weights & Biases; and behind what else stands there of a curve."""
CALLS = ("Step", "_step")
"""What counts how often a run has logged."""
CHARTS = "wandb_export"
WANDB = "Weights & Biases samples a curve before it exports it"
SAMPLED = "TensorBoard exports a sample of at most 1,000 points, unless it was told otherwise"
JOINED = "a value is a mean of several points, or of the runs of a group: its least and greatest differ"
GAPS = "its numbers of episodes have gaps: not every episode stands in it"
FEW = 5
"""Rows from which on a column of a table tells in which order they are."""
CLOCK = re.compile("time|date|clock", re.IGNORECASE)
RISES = 0.8
"""The share of rows from which on a column that rises from row to row counts the steps of a training, or of each."""
OF_D3RLPY = re.compile(r"\d+,\d+,[-\d.e+naif]+\n")
"""Epoch, step and value."""
D3RLPY = {"environment": "eval/mean_reward"}
"""What d3rlpy calls its evaluations in its own examples."""
FOLDERS = {
    "meta.yaml": ("metrics", "*", "when value step"),
    "scalars": ("scalars", "*", "step value"),
    "params.json": ("", "*.csv", "epoch step value"),
}
"""By what else lies there: where a program keeps a file for each of its curves, and what stands in their rows."""
KEYS = ("env", "env_name", "exp_name", "seed")
SETTINGS = ("params.json", "config.json")
"""What RLlib and Spinning Up keep beside a table: the settings of the training."""
KNOWN = {key for keys in ROLES.values() for key in keys}
Columns = dict[str, Float]


@dataclass(frozen=True)
class Table(Roles):
    """Episodes or curves in CSV, TSV or JSON, packed by gzip or not, of whatever program.

    Attributes:
        run: Columns that say of which training a row is, joined by ``+``.
        only: A column and what stands in it, ``mode=train``: no other rows count.
    """

    run: str = ""
    only: str = ""

    def recognises(self, path: Path, head: bytes) -> bool:
        """By the columns that a user names; else by one of returns or success, and one that counts, of no steps."""
        if path.is_dir() or (path.name == "result.json" and path.with_name("progress.csv").exists()):  # of one training
            return bool(_curves_in(path))
        text = head_of(path, head)
        table = first_rows(path, text, _bare_names(path, text))
        names = table.names
        if names[:3] == MONITOR:
            return bool(table.comments) or MONITORED.fullmatch(path.name) is not None
        is_named = bool(self._told) and self._told <= {*names}
        if is_named or names == EXPORT or _is_chart(names) or is_history(names):
            return True
        try:
            chosen = Roles().chosen(path, [name for name in names if not _is_text(table.cells[name])])
        except (UsageError, SchemaError):
            return False
        is_counted = chosen.times or chosen.counter or chosen.unit == "episode"
        has_rows = len(table) > 0 and ("reward" not in map(str.lower, names) or bool(why_no_steps(table)))
        return bool(is_counted and (chosen.kind[0] or chosen.is_mean or has_rows))

    def read(self, path: Path) -> tuple[Log, ...]:
        """A log for each training in it.

        Raises:
            UsageError: A column that was named is not there, none is known, or one may mean two things.
            SchemaError: It is damaged; names the line.
        """
        if path.is_dir():
            return (self._folder(path),)
        text = read_text(path)
        table = parse_table(path, text, _bare_names(path, text))
        named = EXPORTED.fullmatch(path.name)
        if table.names[:3] == MONITOR:
            return (_monitored(table, self),)
        if table.names == EXPORT and named and not self._told & {*EXPORT}:
            return (self._exported(path, named["before"]),)
        return tuple(self._charted(table) if _is_chart(table.names) else self._rows(table))

    def write_example(self, folder: Path) -> Path:
        """Three reports, as stable-baselines3's own logger writes them."""
        path = folder / "progress.csv"
        header = "rollout/ep_rew_mean,rollout/ep_len_mean,time/total_timesteps"
        path.write_text(f"{header}\n-9.5,20.0,2048\n-7.0,18.0,4096\n-2.5,11.0,6144\n", encoding="utf-8")
        return path

    @property
    def _told(self) -> set[str]:
        values = (getattr(self, role) for role in VALUES)
        return {self.time, *values, *self.run.split("+"), self.only.partition("=")[0]} - {""}

    # Rows of one training or of several

    def _rows(self, table: TextTable) -> Iterator[Log]:
        require_columns(table.path, table.names, *self._told)
        if self.only:
            name, _, value = self.only.partition("=")
            counted = [row for row, cell in enumerate(table.cells[name]) if cell.strip() == value]
            if not counted:
                there = ", ".join(sorted({*table.cells[name]})[:8])
                raise UsageError(f"{table.path}: no row has '{value}' in its column '{name}'. There is: {there}")
            table = table.part(counted)
        words = [name for name in table.names if name not in self._told and _is_text(table.cells[name])]
        numbers = [name for name in table.names if name not in words]
        least = FEW if any(plain(name) in ROLES["episode"] for name in numbers) else 2
        counts = [name for name in numbers if plain(name) in OF_ALL]
        rises = {name: np.diff(table.numbers(name, NOTHING)) > 0.0 for name in counts if len(table) >= least}
        rising = [name for name in counts if len(table) < 2 or (name in rises and rises[name].mean() > RISES)]
        told_so = self if self.time or self.length else replace(self, time=next(iter(rising), ""))
        chosen = told_so.chosen(table.path, numbers)
        chosen = chosen._replace(
            times=tuple(it for it in chosen.times if it not in counts or it in (self.time, *rising))
        )
        used = [*chosen.columns.values(), *chosen.times, chosen.counter, chosen.episode, *self._told]
        taught, runs = self._runs(table, words, used)
        seeds = [name for name in table.names if name.lower() in SEED and not is_of_episodes(table, name)]
        used += [*taught, *runs, *seeds]
        left = one_line(", ".join(it for it in table.names if it not in used and it.lower() not in INDEX), 120)
        told = _settings_beside(table.path.parent)
        told |= {key: table.cells[f"config/{key}"][0] for key in ("env", "seed") if f"config/{key}" in table.cells}
        thinned = WANDB if is_history(table.names) else ""
        others = [name for name in numbers if name not in used]
        is_unsure = chosen.is_mean and not (rising or chosen.counter or self.time or self.length)
        for cells, rows in split(table, [*taught, *runs]):
            part = table.part(rows) if cells else table
            if chosen.unit == "point":
                part = _in_order(part, chosen.times[:1], counts if is_unsure else [], others, [*taught, *runs])
            seed = str(part.cells[seeds[0]][0] if seeds and len(part) else told.get("seed", ""))
            facts = LogFacts(
                path=table.path,
                format="history of Weights & Biases" if thinned else f"table of {chosen.unit}s",
                unit=chosen.unit,
                run="_".join(cells),
                env=told.get("env", told.get("env_name", "")),
                algorithm=told.get("exp_name", ""),
                seed=whole(seed),
                thinned=thinned,
                notes=(*([f"not used: {left}"] if left else []), *table.notes),
            )
            if chosen.unit == "episode":
                clock = "" if chosen.times or chosen.episode else _falling_clock(part, used)
                if clock:
                    order = f"'{clock}' falls from row to row: the last row is the first episode"
                    part, facts = part.part(range(len(part))[::-1]), replace(facts, notes=(order, *facts.notes))
                yield _episodes(part, facts, chosen)
                continue
            step = CALLS[1] if thinned else chosen.counter
            columns = {name: part.numbers(name, NOTHING) for name in chosen.columns.values()}
            columns |= {name: part.counts(name, lacks=NOTHING) for name in (*chosen.times, step) if name}
            columns["step"] = columns[step] if step else np.arange(1.0, len(part) + 1.0)
            yield points(facts, chosen, columns, self, step or "rows")

    def _runs(self, table: TextTable, words: Sequence[str], used: Sequence[str]) -> tuple[list[str], list[str]]:
        """Columns that say what taught a training, and those that say which of these it is.

        Raises:
            UsageError: A column may say that rows are of different trainings, or of different kinds.
        """
        if self.run:
            return [], self.run.split("+")
        named = [it for it in table.names if it not in used and (names_a_run(it) or plain(it) in ROLES["mode"])]
        varying = [name for name in named if len({*table.cells[name]}) > 1]
        runs = [name for name in varying if names_a_run(name) and not is_of_episodes(table, name)]
        labels = labels_of(table, [name for name in words if name not in runs])
        taught = [name for name in labels if plain(name) in ROLES["taught"]]
        for name in words:  # another file may name another reward, and the names of files may not
            (first, *others), of_files = {*table.cells[name]}, ROLES["taught"][:-3]
            is_in_path = re.search(rf"(?<![^\W_]){re.escape(first.strip())}(?![^\W_])", str(table.path))
            if plain(name) in of_files and first and not others and not is_in_path:
                taught.append(name)
        groups = split(table, [*taught, *runs])
        modes = [name for name in varying if plain(name) in ROLES["mode"] and name not in labels]
        said = "".join(f"{it.name}={getattr(self, it.name)}," for it in fields(Roles) if getattr(self, it.name))
        for name in [*labels, *modes]:
            if name in taught:
                continue
            cells = table.cells[name]
            if all(len({cells[row] for row in rows}) == 1 for _, rows in groups):
                taught.append(name)
                continue
            some = sorted({cell.strip() for cell in cells})
            how = f"--as 'table:{said}only={name}={some[-1]}' reads those of one"
            if plain(name) not in ROLES["mode"]:
                every = "+".join([*taught, name, *runs])
                how += f"; --as 'table:{said}run={every}' reads each as a training of its own"
            raise AskedError(
                f"{table.path}: column '{name}' holds {', '.join(some[:4])} in the rows of one training. {how}"
            )
        return taught, runs

    # Curves that stand in columns or files of their own

    def _folder(self, path: Path) -> Log:
        """The one training whose values a program keeps in a file each."""
        name, seed = path / "tags/mlflow.runName", path / "params/seed"
        told = read_text(seed).strip() if seed.is_file() else _settings_beside(path).get("seed", "")
        facts = LogFacts(
            path=path,
            format="folder of curves",
            run=read_text(name).strip() if name.is_file() else "",
            seed=whole(told),
        )
        series = {
            tag: _series(parse_table(file, read_text(file).replace(" ", ","), names.split()), "step", "value")
            for tag, (file, names) in _curves_in(path).items()
        }
        return curve(facts, series, self, "" if name.is_file() else "steps of its own")

    def _exported(self, path: Path, before: str) -> Log:
        """The curves of a run that lie beside one another, each in a file whose name has the run and the tag."""
        named = [it for file in sorted(path.parent.iterdir()) if (it := EXPORTED.fullmatch(file.name))]
        files = {_tag(it["tag"]): path.parent / it[0] for it in named if it["before"] == before}
        tables = {tag: parse_table(file, read_text(file)) for tag, file in files.items()}
        notes = tuple(note for it in tables.values() for note in it.notes)
        first = next(iter(files.values()))
        facts = LogFacts(path=first, format="export of TensorBoard", thinned=SAMPLED, notes=notes)
        return curve(facts, {tag: _series(it, "Step", "Value") for tag, it in tables.items()}, self)

    def _charted(self, table: TextTable) -> Iterator[Log]:
        """Each run of a chart, with its curves in the charts that lie beside it."""
        axis, path = table.names[0], table.path
        places = sorted(path.parent.glob(f"{CHARTS}*.csv")) if path.name.startswith(CHARTS) else [path]
        charts = [table if it == path else parse_table(it, read_text(it)) for it in places]
        found = [
            (chart, name, *name.rpartition(BETWEEN)[::2])
            for chart in charts
            for name in chart.names[1:]
            if chart.names[0] == axis and BETWEEN in name and not ENDS.search(name)
        ]
        for run in sorted({run for chart, _, run, _ in found if chart is table}):
            of = {tag: (chart, name) for chart, name, other, tag in found if other == run}
            is_joined = any(
                chart.cells.get(f"{name}__MIN") != chart.cells.get(f"{name}__MAX") for chart, name in of.values()
            )
            facts = LogFacts(
                path=next(chart.path for chart, _, other, _ in found if other == run),
                format="export of Weights & Biases",
                run=run,
                thinned=f"{WANDB}; {JOINED}" if is_joined else WANDB,
                notes=table.notes,
                **cleanrl_run(run),
            )
            yield curve(facts, {tag: _series(chart, axis, name) for tag, (chart, name) in of.items()}, self, axis)


def _is_chart(names: Sequence[str]) -> bool:
    charted = [name for name in names[1:] if BETWEEN in name]
    return bool(charted) and (names[0] in CALLS or any(map(ENDS.search, charted)))


def _is_text(cells: Sequence[str]) -> bool:
    """Whether a column holds words: its first cell that holds anything begins like one."""
    first = next((it.strip() for it in cells if it.strip()), "")
    return first[:1].isalpha() and first.lower() not in (*NOTHING, *TRUTH, "inf", "infinity")


def _in_order(
    table: TextTable, times: Sequence[str], unsure: Sequence[str], others: Sequence[str], runs: Sequence[str]
) -> TextTable:
    """The table of a training with its rows in the order of its steps.

    Args:
        table: Of one training.
        times: The column that counts the steps of the training.
        unsure: Columns that may count them, in another order.
        others: Columns of numbers that say nothing so far.
        runs: Columns that say of which training a row is.

    Raises:
        UsageError: One may count the steps, or say of which training a row is.
    """
    for name in [*times, *unsure]:
        at = table.numbers(name, NOTHING)
        back = np.flatnonzero(np.diff(at) < 0.0)
        if len(back) <= (1.0 - RISES) * len(at):
            for other in others if len(back) else ():
                with suppress(SchemaError):
                    if np.array_equal(np.flatnonzero(np.diff(table.numbers(other, NOTHING))), back):
                        run = "+".join([other, *runs])
                        raise AskedError(
                            f"{table.path}: '{name}' goes back where column '{other}' changes. --as 'table:run={run}' "
                            "reads each as a training of its own"
                        )
            continue
        if len(np.unique(at)) < len(at):
            continue  # it counts something else
        if name in unsure:
            raise AskedError(
                f"{table.path}: column '{name}' goes up and down. --as table:time={name} sorts the rows by it; "
                f"--as table:length={name} says that it holds the lengths of episodes"
            )
        table = table.part(np.argsort(at))
    return table


def _falling_clock(table: TextTable, used: Sequence[str]) -> str:
    """The column of a clock that falls from row to row, so that the newest stand first; empty without one."""
    for name in table.names:
        cells = np.array(table.cells[name])
        with suppress(ValueError):  # dates are sorted as text
            cells = cells.astype(float)
        if len(cells) >= FEW and name not in used and CLOCK.search(name) and (cells[1:] < cells[:-1]).all():
            return name
    return ""


def _tag(written: str) -> str:
    """The tag that a file's name means, in which an underscore may stand for a slash."""
    for place, sign in enumerate(written):
        if sign in "_-" and place and plain(written[place + 1 :]) in KNOWN:
            return f"{written[:place]}/{written[place + 1 :]}"
    return written


def _series(table: TextTable, axis: str, name: str) -> Series:
    values = table.numbers(name, NOTHING)
    is_told = ~np.isnan(values)
    return table.numbers(axis)[is_told], values[is_told]


def _settings_beside(folder: Path) -> dict[str, str]:
    """The settings of the training, where a program left them in the folder; empty if they cannot be read."""
    for name in SETTINGS:
        with suppress(OSError, ValueError, AttributeError):
            told = parse_json(read_bytes(folder / name)).items()
            return {key: str(it) for key, it in told if key in KEYS and isinstance(it, str | int | float)}
    return {}


def _curves_in(path: Path) -> dict[str, tuple[Path, str]]:
    """By tag the files of a run of MLflow, of TorchRL or of d3rlpy, and what stands in their rows."""
    found = dict[str, tuple[Path, str]]()
    with suppress(OSError, SchemaError):
        mark = next((it for it in FOLDERS if (path / it).exists()), "")
        place, pattern, names = FOLDERS.get(mark, ("", "", ""))
        for file in sorted((path / place).rglob(pattern)) if mark else ():
            # other programs keep tables beside settings of that name
            if file.is_file() and (mark != "params.json" or OF_D3RLPY.match(read_text(file))):
                tag = file.relative_to(path / place).as_posix().removesuffix(".csv")
                found[D3RLPY.get(tag, tag)] = file, names
    return found


# Episodes


def _episodes(table: TextTable, facts: LogFacts, chosen: Chosen) -> Log:
    if not len(table):
        raise SchemaError(f"{table.path} holds no episode yet")
    roles = {
        **chosen.columns,
        "time": next(iter(chosen.times), ""),
        "episode": chosen.episode,
        "env": ENV if ENV in table.names else "",
    }
    roles = {role: name for role, name in roles.items() if name}
    is_told = table.names[:3] == MONITOR  # that a row is an episode
    fault = None if is_told else fault_of_episodes(table, roles, np.arange(len(table)))
    if fault:
        raise table.refused(fault.row, fault.why)
    columns: Columns = {
        column_of(role, name): table.truths(name) if role == "success" else table.numbers(name, ("nan",))
        for role, name in chosen.columns.items()
        if role != "length"
    }
    is_counted = "episode" in roles and "env" not in roles
    is_gappy = is_counted and bool((np.diff(table.numbers(roles["episode"])) != 1.0).any())
    if "length" in roles:
        columns["length"] = table.counts(roles["length"], least=1)
        if not is_gappy:
            columns[TIME] = np.cumsum(columns["length"])
    if "time" in roles:
        columns[TIME] = table.counts(roles["time"])
        back = np.flatnonzero(np.diff(columns[TIME]) < 0.0)
        if len(back):
            raise table.refused(int(back[0] + 1), f"'{roles['time']}' goes back: the file holds several runs")
    facts = replace(
        facts,
        bounds={"success": (0.0, 1.0)} if "success" in roles else {},
        thinned=GAPS if is_gappy else "",
        notes=(", ".join(f"{role} from '{name}'" for role, name in roles.items()), *facts.notes),
    )
    return in_memory(facts, columns)


def _monitored(table: TextTable, told: Roles) -> Log:
    """Episodes of one environment, or of several that train side by side, as Monitor and VecMonitor write them."""
    path = table.path
    try:
        heads = [json.loads(text[1:]) for text in table.comments] or [{}]
    except (ValueError, RecursionError) as error:
        raise SchemaError(f"{path}: behind # stands no object of JSON: {one_line(error)}") from error
    env, *others = sorted({str(head.get("env_id") or "None") for head in heads})
    if others:
        raise SchemaError(f"{path} holds episodes of several environments: {', '.join([env, *others])}")
    success = told.success or next((name for name in ("is_success", "success") if name in table.names), "")
    require_columns(path, table.names, success)
    columns = {"reward": "r", "length": "l"} | ({"success": success} if success else {})
    log = _episodes(table, LogFacts(path=path, format=""), Chosen(columns, unit="episode"))
    seconds = table.numbers("t", NOTHING)
    further, measured = [name for name in table.names[3:] if name != success], Columns()
    for name in further:
        if not PAY.search(name) and not name.startswith(NAMELESS):
            with suppress(SchemaError):
                measured[name] = table.numbers(name)
    left = [name for name in further if name not in measured]
    back = np.flatnonzero(np.diff(seconds) < 0.0)
    line = table.lines[int(back[0]) + 1] if len(back) else 0
    again = f"its clock goes back {len(back)} times, first in line {line}: it was continued, or several envs write it"
    notes = {
        f"Success is read from '{success}'": success,
        f"taken as measures: {', '.join(measured)}": measured,
        f"left out, as pay, text or without a name: {', '.join(left)}": left,
        **dict.fromkeys(table.notes, True),
        again: len(back),
    }
    started = heads[0].get("t_start")
    facts = replace(
        log.facts,
        format="Monitor of stable-baselines3",
        unit="episode",
        **zoo_settings(path, "" if env == "None" else env)._asdict(),
        started=float(started) if isinstance(started, int | float) else None,
        notes=tuple(note for note, is_so in notes.items() if is_so),
    )
    return in_memory(facts, {**log.known, "seconds": seconds, **{f"behaviour/{it}": of for it, of in measured.items()}})


def _bare_names(path: Path, text: str) -> Sequence[str]:
    """Names of the columns of a file of Monitor without a header; empty of any other."""
    first = text[: text.find("\n")]
    if MONITORED.fullmatch(path.name) is None or BARE_ROW.match(first) is None:
        return ()
    return (*MONITOR, *(f"{NAMELESS}{number}" for number in range(4, first.count(",") + 2)))
