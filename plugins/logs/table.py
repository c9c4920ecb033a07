"""Any table of a training, or of several: one reader, whoever wrote it.

A row is an episode, or a point of a curve. Columns are found by their names, see `curves`. A column of text says of
which training a row is, or is asked about: none is passed over without a word.
"""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.errors import AskedError, SchemaError, UsageError
from harness.files.bounded import read_json
from harness.log import BEHAVIOUR, RECORDED, REWARD, SUCCESS, Log, LogFacts, in_memory
from harness.log.text_table import NOTHING, TextTable, head_of, parse_table, read_text, require_columns
from harness.score.row_meaning import (
    ENV,
    INDEX,
    SEED,
    fault_of_episodes,
    is_of_episodes,
    labels_of,
    names_a_run,
    split,
    watched_columns,
    why_no_steps,
)
from harness.text import shortened

from ..curves import (
    CLEANRL_RUN,
    MEANS,
    POINTS,
    ROLES,
    TIME,
    Roles,
    Series,
    aligned,
    column_of,
    plain,
    points,
    roles_of,
)
from ..zoo_settings import zoo_settings

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
"""Rows from which on lengths that only rise are taken for a count over all episodes."""
TAUGHT = (
    "rewardfn", "rewardfunction", "rewardname", "rewardtype", "reward", "method", "variant", "condition", "treatment",
    "algo", "algorithm", "group",
)  # fmt: skip
"""Columns of text that say what taught a training."""
MODES = ("mode", "split", "phase", "stage", "agent", "agentid", "player", "policyid")
"""Columns that say which rows of a training count."""
OF_D3RLPY = re.compile(r"\d+,\d+,[-\d.e+naif]+\n")
"""Epoch, step and value."""
D3RLPY = {"environment": "eval/mean_reward"}
"""What d3rlpy calls its evaluations in its own examples."""
SETTINGS = ("params.json", "config.json")
"""What RLlib and Spinning Up keep beside a table: the settings of the training."""
KNOWN = {key for keys in ROLES.values() for key in keys} | {*MODES, *map(plain, SEED), "envid", "env", "name"}
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
        """By a column of returns or success, and one that counts; the rows are no steps."""
        if path.is_dir() or (path.name == "result.json" and path.with_name("progress.csv").exists()):  # of one training
            return bool(_curves_in(path))
        text = head_of(path, head)
        lines = text.splitlines(keepends=True)
        for kept in (len(lines), 2 if text.startswith("#") else 1):  # a row further down may be damaged
            with suppress(SchemaError):
                table = parse_table(path, "".join(lines[:kept]), None, _bare_names(path, text))
                break
        else:
            return False
        names = table.names
        if names[:3] == MONITOR:
            return bool(table.comments) or MONITORED.fullmatch(path.name) is not None
        return names == EXPORT or _is_chart(names) or _is_history(names) or _has_rows(table)

    def read(self, path: Path) -> tuple[Log, ...]:
        """A log for each training in it.

        Raises:
            UsageError: A column that was named is not there, none is known, or one may mean two things.
            SchemaError: It is damaged; names the line.
        """
        if path.is_dir():
            return (self._folder(path),)
        text = read_text(path)
        table = parse_table(path, text, self._wanted, _bare_names(path, text))
        if table.names[:3] == MONITOR and "reward" not in table.names:
            return (_monitored(table, self),)
        if table.names == EXPORT:
            return (self._exported(table),)
        if _is_chart(table.names):
            return tuple(self._charted(table, path))
        return tuple(self._rows(table))

    def write_example(self, folder: Path) -> Path:
        """Three reports by stable-baselines3's own logger; the same lines where it is not installed."""
        path = folder / "progress.csv"
        rows = [(-9.5, 20.0, 2048), (-7.0, 18.0, 4096), (-2.5, 11.0, 6144)]
        names = ("rollout/ep_rew_mean", "rollout/ep_len_mean", "time/total_timesteps")
        try:
            from stable_baselines3.common.logger import CSVOutputFormat
        except ImportError:
            lines = [",".join(map(str, row)) for row in (names, *rows)]
            path.write_text("\n".join(lines) + "\n", encoding="utf-8")
            return path
        writer = CSVOutputFormat(str(path))
        for row in rows:
            writer.write(dict(zip(names, row, strict=True)), dict.fromkeys(names, ()))
        writer.close()
        return path

    @property
    def _told(self) -> set[str]:
        given = {self.time, self.reward, self.success, self.length, self.measure, self.only.partition("=")[0]}
        return {*given, *self.run.split("+")} - {""}

    def _wanted(self, names: tuple[str, ...], rows: Sequence[Sequence[str]]) -> list[str]:
        """Those that may be read, and those of text: a table of RLlib has hundreds."""
        if names[:3] == MONITOR or names == EXPORT or _is_chart(names):
            return list(names)
        words = {name for place, name in enumerate(names) if _is_text([row[place] for row in rows if place < len(row)])}
        of = ((name, {plain(name), plain(name.rpartition("/")[2])}) for name in names)
        return [name for name, keys in of if keys & KNOWN or name in words | self._told or names_a_run(name)]

    # Rows of one training or of several

    def _rows(self, table: TextTable) -> Iterator[Log]:
        table = self._counted(table)
        words = [name for name in table.cells if name not in self._told and _is_text(table.cells[name])]
        numbers = [name for name in table.names if name not in words]
        roles = self._roles_in(table, numbers)
        taught, runs = self._runs(table, words, roles)
        used = {*roles.values(), *taught, *runs, *self._told}
        left = [name for name in table.names if name not in used and name.lower() not in INDEX]
        for cells, rows in split(table, [*taught, *runs]):
            of = dict(zip([*taught, *runs], cells, strict=True))
            seed = next((of[name] for name in runs if name.lower() in SEED), "")
            facts = self._facts(table, "_".join(cells), seed, left)
            part = table.part(rows.tolist()) if cells else table
            yield self._points(part, facts, numbers) if self._is_curve(table, roles) else _episodes(part, facts, roles)

    def _counted(self, table: TextTable) -> TextTable:
        """The rows that count."""
        name, _, value = self.only.partition("=")
        require_columns(table.path, table.names, *self._told)
        if not name:
            return table
        rows = [row for row, cell in enumerate(table.cells[name]) if cell.strip() == value]
        if not rows:
            there = ", ".join(sorted({*table.cells[name]})[:8])
            raise UsageError(f"{table.path}: no row has '{value}' in its column '{name}'. There is: {there}")
        return table.part(rows)

    def _roles_in(self, table: TextTable, names: Sequence[str]) -> dict[str, str]:
        """By role: the column. One of returns or success is there.

        Raises:
            UsageError: None is known.
        """
        found = roles_of(names)
        given = {"time": self.time, "reward": self.reward, "length": self.length, "success": self.success}
        given["measure"] = self.measure
        found = {**found, **{role: name for role, name in given.items() if name}}
        if not {"reward", "success"} & found.keys():
            found |= roles_of(names, evaluation=True)
        if not {"reward", "success"} & found.keys():
            there = shortened(", ".join(table.names), 160)
            raise UsageError(f"{table.path} has no column of returns that is known: say reward=NAME. It has: {there}")
        return found

    def _is_curve(self, table: TextTable, roles: Mapping[str, str]) -> bool:
        """Whether a row is a point of a curve; else it is an episode."""
        keys = {plain(roles[role].rpartition("/")[2]) for role in ("reward", "success", "length") if role in roles}
        is_mean = any(MEANS.search(key) for key in keys) or _is_history(table.names)
        return is_mean or not {"episode", "length"} & roles.keys()

    def _runs(self, table: TextTable, words: Sequence[str], roles: Mapping[str, str]) -> tuple[list[str], list[str]]:
        """Columns that say what taught a training, and those that say which of these it is.

        Raises:
            UsageError: A column may say that rows are of different trainings, or of different kinds.
        """
        if self.run:
            return [], self.run.split("+")
        varying = [name for name in table.cells if len({*table.cells[name]}) > 1 and name not in roles.values()]
        runs = [name for name in varying if names_a_run(name) and not is_of_episodes(table, name)]
        labels = labels_of(table, [name for name in words if name not in runs])
        taught = [name for name in labels if plain(name) in TAUGHT]
        groups = split(table, [*taught, *runs])
        modes = [name for name in varying if plain(name) in MODES and name not in labels]
        for name in [*labels, *modes]:
            if name in taught or name in self._told:
                continue
            cells = table.cells[name]
            if all(len({cells[row] for row in rows}) == 1 for _, rows in groups):
                taught.append(name)
                continue
            some = sorted({cell.strip() for cell in cells})
            how = f"--as '{READER}:{self._said}only={name}={some[-1]}' reads those of one"
            if plain(name) not in MODES:
                every = "+".join([*taught, name, *runs])
                how += f"; --as '{READER}:{self._said}run={every}' reads each as a training of its own"
            raise AskedError(
                f"{table.path}: column '{name}' holds {', '.join(some[:4])} in the rows of one training. {how}"
            )
        return taught, runs

    @property
    def _said(self) -> str:
        """What the user said so far, to be typed again."""
        names = ("time", "reward", "success", "length", "measure", "per_step", "episode")
        return "".join(f"{name}={getattr(self, name)}," for name in names if getattr(self, name))

    def _facts(self, table: TextTable, run: str, seed: str, left: Sequence[str]) -> LogFacts:
        told = _settings_beside(table.path)
        told |= {key: table.cells[f"config/{key}"][0] for key in ("env", "seed") if f"config/{key}" in table.cells}
        seed = seed or str(told.get("seed"))
        unused = shortened(", ".join(left), 120)
        return LogFacts(
            path=table.path,
            format="history of Weights & Biases" if _is_history(table.names) else "table of points",
            run=run,
            env=next((told[key] for key in ("env", "env_name") if isinstance(told.get(key), str)), ""),
            algorithm=told["exp_name"] if isinstance(told.get("exp_name"), str) else "",
            seed=int(seed) if seed.isdecimal() else None,
            thinned=WANDB if _is_history(table.names) else "",
            notes=(*([f"not used: {unused}"] if left else []), *table.notes),
        )

    def _points(self, table: TextTable, facts: LogFacts, names: Sequence[str]) -> Log:
        chosen = self.chosen(table.path, names)
        columns = {name: table.numbers(name, NOTHING) for name in chosen.columns.values()}
        columns |= {name: table.counts(name, lacks=NOTHING) for name in chosen.times}
        step = next((name for name in CALLS if name in names), "") if _is_history(names) else chosen.counter
        columns["step"] = table.counts(step, lacks=NOTHING) if step else np.arange(1.0, len(table) + 1.0)
        return points(facts, chosen, columns, self, step or "rows")

    # Curves that stand in files of their own

    def _folder(self, path: Path) -> Log:
        """The one training whose values a program keeps in a file each."""
        series = {}
        for tag, (file, step, value) in _curves_in(path).items():
            lines = enumerate(read_text(file).splitlines(keepends=True), 1)
            rows = [(at, re.split("[ ,]", line.strip())) for at, line in lines if line.strip() and line.endswith("\n")]
            names = tuple(map(str, range(len(rows[0][1]) if rows else 0)))
            if any(len(row) != len(names) for _, row in rows) or len(names) <= max(step, value):
                raise SchemaError(f"{file}: its rows are no step with a value")
            cells = dict(zip(names, map(list, zip(*(row for _, row in rows), strict=True)), strict=True))
            table = TextTable(file, names, cells, [at for at, _ in rows])
            series[tag] = Series(table.numbers(str(step)).tolist(), table.numbers(str(value), NOTHING).tolist())
        chosen = self.chosen(path, list(series))
        name, seed = path / "tags/mlflow.runName", path / "params/seed"
        told = read_text(seed).strip() if seed.is_file() else str(_settings_beside(path / "it").get("seed"))
        facts = LogFacts(
            path=path,
            format="folder of curves",
            run=read_text(name).strip() if name.is_file() else "",
            seed=int(told) if told.isdecimal() else None,
        )
        return points(facts, chosen, aligned(series, chosen), self, "" if name.is_file() else "steps of its own")

    def _exported(self, table: TextTable) -> Log:
        """The curves of a run that lie beside one another, each in a file whose name has the run and the tag."""
        named = EXPORTED.fullmatch(table.path.name)
        files = {table.path: "Value"}
        if named and not self._told & {*EXPORT}:
            of = ((path, EXPORTED.fullmatch(path.name)) for path in sorted(table.path.parent.iterdir()))
            files = {path: _tag(it["tag"]) for path, it in of if it and it["before"] == named["before"]}
        tables = {path: table if path == table.path else parse_table(path, read_text(path)) for path in files}
        names = [*files.values()] if named else [*EXPORT]
        series = {
            tag: Series(tables[path].numbers("Step").tolist(), tables[path].numbers("Value", NOTHING).tolist())
            for path, tag in files.items()
        }
        chosen = self.chosen(table.path, names if named and not self._told & {*EXPORT} else EXPORT)
        facts = LogFacts(
            path=next(iter(files)),
            format="export of TensorBoard",
            thinned=SAMPLED,
            notes=tuple(note for it in tables.values() for note in it.notes),
        )
        return points(facts, chosen, aligned(series, chosen), self)

    def _charted(self, table: TextTable, path: Path) -> Iterator[Log]:
        """Each run of a chart, with its curves in the charts that lie beside it."""
        axis = table.names[0]
        places = sorted(path.parent.glob(f"{CHARTS}*.csv")) if path.name.startswith(CHARTS) else [path]
        tables = {it: table if it == path else parse_table(it, read_text(it)) for it in places}
        charts = [it for it in tables.values() if it.names[0] == axis and _is_chart(it.names)]
        runs: dict[str, dict[str, TextTable]] = {}
        for chart in charts:
            for name in chart.names[1:]:
                run, between, tag = name.rpartition(BETWEEN)
                if between and not ENDS.search(tag):
                    runs.setdefault(run, {}).setdefault(tag, chart)
        for run, of in sorted(runs.items()):
            if not any(name.startswith(f"{run}{BETWEEN}") for name in table.names):
                continue
            series = {tag: _series(chart, axis, f"{run}{BETWEEN}{tag}") for tag, chart in of.items()}
            chosen = self.chosen(path, list(of))
            columns = aligned(series, chosen)
            if plain(axis) in ROLES["time"]:
                columns[axis] = columns["step"]
                chosen = chosen._replace(times=(axis, *chosen.times))
            is_joined = any(_differ(of[tag], f"{run}{BETWEEN}{tag}") for tag in chosen.columns.values())
            named = CLEANRL_RUN.fullmatch(run)
            facts = LogFacts(
                path=next(iter(of.values())).path,
                format="export of Weights & Biases",
                run=run,
                env=named["env"] if named else "",
                algorithm=named["algorithm"] if named else "",
                seed=int(named["seed"]) if named else None,
                thinned="; ".join([WANDB, *([JOINED] if is_joined else [])]),
                notes=table.notes,
            )
            yield points(facts, chosen, columns, self, axis)


READER = "table"


def _has_rows(table: TextTable) -> bool:
    """Whether rows are episodes, or points that are counted."""
    names = [name for name in table.names if not _is_text(table.cells[name])]
    roles = {**roles_of(names, evaluation=True), **roles_of(names)}
    value = roles.get("reward") or roles.get("success")
    if not value or not {"time", "counter", "episode", "length"} & roles.keys():
        return False
    if MEANS.search(plain(value)) or POINTS.keys() & {plain(value), plain(value.rpartition("/")[2])}:
        return True
    lower = [name.lower() for name in table.names]
    watched = {it.role: table.names[it.position] for it in watched_columns(lower)}
    try:
        return len(table) > 0 and ("reward" not in lower or bool(why_no_steps(table, watched)))
    except SchemaError:
        return False


def _is_chart(names: Sequence[str]) -> bool:
    charted = [name for name in names[1:] if BETWEEN in name]
    return bool(charted) and (names[0] in CALLS or any(map(ENDS.search, charted)))


def _is_history(names: Sequence[str]) -> bool:
    """Whether a table is the history of a run of Weights & Biases, which has the names of whatever logged into it."""
    return {"_step", "_timestamp"} <= {*names}


def _is_text(cells: Sequence[str]) -> bool:
    """Whether a column holds words: its first cell that holds anything begins like one."""
    first = next((it.strip() for it in cells if it.strip()), "")
    return first[:1].isalpha() and first.lower() not in (*NOTHING, "true", "false", "inf", "infinity")


def _tag(written: str) -> str:
    """The tag that a file's name means, in which an underscore may stand for a slash."""
    for place, sign in enumerate(written):
        if sign in "_-" and place and plain(written[place + 1 :]) in KNOWN:
            return f"{written[:place]}/{written[place + 1 :]}"
    return written


def _series(table: TextTable, axis: str, name: str) -> Series:
    values, steps = table.numbers(name, NOTHING), table.numbers(axis)
    there = ~np.isnan(values)
    return Series(steps[there].tolist(), values[there].tolist())


def _differ(table: TextTable, name: str) -> bool:
    """Whether the least and the greatest that stand beside a curve differ anywhere."""
    ends = [table.numbers(end, NOTHING) for end in (f"{name}__MIN", f"{name}__MAX") if end in table.cells]
    return len(ends) == 2 and bool(np.nansum(np.abs(ends[0] - ends[1])) > 0.0)


def _settings_beside(path: Path) -> dict[str, Any]:
    """The settings of the training, where a program left them in the same folder; empty if they cannot be read."""
    for name in SETTINGS:
        try:
            told = read_json(path.with_name(name))
        except (OSError, ValueError):
            continue
        if isinstance(told, dict):
            return told
    return {}


def _curves_in(path: Path) -> dict[str, tuple[Path, int, int]]:
    """By tag the files of a run of MLflow, of TorchRL or of d3rlpy: where in a row its step and its value stand."""
    try:
        if (path / "meta.yaml").is_file():
            of, at = path / "metrics", (2, 1)
        elif (path / "scalars").is_dir():
            of, at = path / "scalars", (0, 1)
        else:
            of, at = path, (1, 2)
        if of == path and not (path / "params.json").is_file():
            return {}
        files = [file for file in sorted(of.glob("*.csv") if of == path else of.rglob("*")) if file.is_file()]
        found = [file for file in files if of != path or OF_D3RLPY.match(read_text(file))]
    except (OSError, SchemaError):
        return {}
    tags = {file: file.relative_to(of).as_posix().removesuffix(".csv") for file in found}
    return {D3RLPY.get(tag, tag) if of == path else tag: (file, *at) for file, tag in tags.items()}


# Episodes


def _episodes(table: TextTable, facts: LogFacts, roles: Mapping[str, str]) -> Log:
    if not len(table):
        raise SchemaError(f"{table.path} holds no episode yet")
    roles = {**roles, **{role: name for role, name in (("env", ENV),) if name in table.cells}}
    rows = np.arange(len(table))
    fault = fault_of_episodes(table, roles, rows)
    if fault:
        raise table.refused(fault.row, fault.why)
    columns: Columns = {}
    for role in ("reward", "success", "measure"):
        if role in roles:
            of = table.truths(roles[role]) if role == "success" else table.numbers(roles[role], ("nan",))
            columns[column_of(role, roles[role])] = of
    is_gappy = (
        "episode" in roles and "env" not in roles and bool((np.diff(table.numbers(roles["episode"])) != 1.0).any())
    )
    notes = [", ".join(f"{role} from '{name}'" for role, name in roles.items() if role != "counter")]
    if "length" in roles:
        lengths = table.counts(roles["length"], least=1)
        if len(lengths) >= FEW and (np.diff(lengths) > 0.0).all():
            notes.append(f"'{roles['length']}' only rises: it is taken to count the steps of all episodes")
            columns[TIME] = lengths
        else:
            columns["length"] = lengths
            if not is_gappy:
                columns[TIME] = np.cumsum(lengths)
    if "time" in roles:
        columns[TIME] = table.counts(roles["time"])
        back = np.flatnonzero(np.diff(columns[TIME]) < 0.0)
        if len(back):
            raise table.refused(int(back[0] + 1), f"'{roles['time']}' goes back: the file holds several runs")
    facts = replace(
        facts,
        format="table of episodes",
        unit="episode",
        bounds={SUCCESS: (0.0, 1.0)} if "success" in roles else {},
        thinned=GAPS if is_gappy else "",
        notes=(*notes, *facts.notes),
    )
    return in_memory(facts, columns)


def _monitored(table: TextTable, told: Roles) -> Log:
    """Episodes of one environment, or of several that train side by side, as Monitor and VecMonitor write them."""
    path = table.path
    require_columns(path, table.names, told.success)
    if not len(table):
        raise SchemaError(f"{path} holds no episode yet")
    heads = [_object(path, line, text) for line, text in table.comments]
    envs = sorted({str(head.get("env_id") or "") for head in heads})
    if len(envs) > 1:
        raise SchemaError(f"{path} holds episodes of several environments: {', '.join(envs)}")
    success = told.success or next((name for name in ("is_success", "success") if name in table.names), "")
    lengths, seconds = table.counts("l", least=1), table.numbers("t", NOTHING)
    columns = {f"{REWARD}{RECORDED}": table.numbers("r", ("nan",)), "length": lengths}
    columns |= {TIME: np.cumsum(lengths), "seconds": seconds}
    if success:
        columns[f"{BEHAVIOUR}{SUCCESS}"] = table.truths(success)
    further = [name for name in table.names[3:] if name != success]
    measured = {name: values for name in further if (values := _measured(table, name)) is not None}
    left = [name for name in further if name not in measured]
    columns |= {f"{BEHAVIOUR}{name}": values for name, values in measured.items()}
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
    started = heads[0].get("t_start") if heads else None
    env = "" if envs in ([], ["None"]) else envs[0]
    zoo = zoo_settings(path, env)
    facts = LogFacts(
        path=path,
        format="Monitor of stable-baselines3",
        unit="episode",
        env=env or zoo.env,
        algorithm=zoo.algorithm,
        seed=zoo.seed,
        asked=zoo.asked,
        started=float(started) if isinstance(started, int | float) else None,
        bounds={SUCCESS: (0.0, 1.0)} if success else {},
        notes=tuple(note for note, is_so in notes.items() if is_so),
    )
    return in_memory(facts, columns)


def _bare_names(path: Path, text: str) -> Sequence[str]:
    """Names of the columns of a file of Monitor without a header; empty of any other."""
    first = text[: text.find("\n")]
    if MONITORED.fullmatch(path.name) is None or BARE_ROW.match(first) is None:
        return ()
    return (*MONITOR, *(f"{NAMELESS}{number}" for number in range(4, first.count(",") + 2)))


def _object(path: Path, line: int, text: str) -> dict[str, Any]:
    try:
        told = json.loads(text.lstrip("#"))
    except (ValueError, RecursionError):
        told = None
    if not isinstance(told, dict):
        raise SchemaError(f"{path}, line {line}: behind # stands no JSON object")
    return told


def _measured(table: TextTable, name: str) -> Float | None:
    """A further column that can be a measure; None of pay, of what is no number everywhere, and of one without name."""
    if PAY.search(name) or name.startswith(NAMELESS):
        return None
    try:
        return table.numbers(name)
    except SchemaError:
        return None
