"""Folders of somebody who recomputed every digest, so that the lie is read."""

import json
import os
import shutil

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from harness.executor import Cell
from harness.files.bounded import FIRST_LINE, digest_of, note_made, seal

ESCAPE = "\x1b]0;owned\x07\x1b[2J\u202e"
"""What a terminal would obey."""
CANARY = "canary"
"""A tree beside the folder that nobody may touch."""
EVIL = "evil.py"
"""A module in it that leaves a file when it is imported."""
DEEP = 900
"""As deep as JSON is read, and deeper than anything is written."""


def write_canary(place):
    """A tree with files that a forged folder would like to have moved, changed or run."""
    (place / "cells" / "0123456789abcdef").mkdir(parents=True)
    (place / "victim").write_text("a person's\n")
    (place / "victim.half").write_text("a person's, without an end")
    (place / "cells" / "0123456789abcdef" / "manifest.json").write_text("{}")
    ran = f"from pathlib import Path\nPath({str(place)!r}, 'ran').write_text('ran')\n"
    (place / EVIL).write_text(ran)
    (place / "program").write_text(f"#!/bin/sh\ntouch '{place}/ran'\n")
    (place / "program").chmod(0o755)


def first_cell(folder):
    """Of all cells."""
    return sorted((folder / "cells").iterdir())[0]


def change(path, by):
    """A sealed file, and its digest after it."""
    content = json.loads(path.read_text())
    del content["digest"]
    by(content)
    path.write_bytes(seal(content))


def in_plan(by):
    """Something in the plan."""
    return lambda folder: change(folder / "plan.json", by)


def in_manifest(**told):
    """These keys of a cell's manifest."""
    return lambda folder: change(first_cell(folder) / "manifest.json", lambda content: content.update(told))


def table(name, by):
    """A trace, whose digest the manifest then names."""

    def forge(folder):
        cell = first_cell(folder)
        pq.write_table(by(pq.read_table(cell / name)), cell / name)
        _name_digest(cell, name)

    return forge


def _with_a_wrong_end(folder):
    """A column that may have gaps is told to have none, beside counts of its gaps: C++ throws where they are read."""
    cell = first_cell(folder)
    told = bytearray((cell / "trace.parquet").read_bytes())
    end = len(told) - 8 - int.from_bytes(told[-8:-4], "little")
    told[told.index(b"\x25\x02", end) + 1] = 0
    (cell / "trace.parquet").write_bytes(told)
    _name_digest(cell, "trace.parquet")


def column(name, value):
    """All values of a column."""

    def by(found):
        place = found.schema.get_field_index(name)
        field = found.schema.field(place)
        return found.set_column(place, field, pa.array(np.full(len(found), value), field.type))

    return by


def _name_digest(cell, name):
    change(cell / "manifest.json", lambda content: content["files"].update({name: digest_of(cell / name)}))


def _listed(place, *names):
    """A list of digests that names other files than the harness makes."""

    def forge(folder):
        target = folder / place.format(cell=first_cell(folder).name)
        lines = [f"{FIRST_LINE}\n", *(f"{'0' * 64}  {name}\n" for name in sorted(names))]
        (target / "SHA256SUMS").write_text("".join(lines), errors="surrogateescape")

    return forge


def _files(*names):
    return lambda folder: change(
        first_cell(folder) / "manifest.json", lambda content: content["files"].update(dict.fromkeys(names, "0" * 64))
    )


def _every_cell(**told):
    """These keys of every cell of the plan, and of the cells themselves, which move to the names of what they are."""
    return in_plan(lambda content: [cell.update(told) for cell in content["cells"]])


def _relabelled(name="", **labels):
    """Other labels, and names, in every cell, which then has another id, and so has its folder."""

    def by(cell):
        for kind, label in labels.items():
            cell[kind] |= {"label": label, "name": name or cell[kind]["name"]}

    def forge(folder):
        shutil.rmtree(folder / "derived")
        for place in sorted((folder / "cells").iterdir()):
            change(place / "manifest.json", lambda content: by(content["cell"]))
            cell = Cell.from_json(json.loads((place / "manifest.json").read_text())["cell"])
            change(place / "manifest.json", lambda content, cell=cell: content.update(id=cell.id))
            place.rename(place.with_name(cell.id))
        change(folder / "plan.json", lambda content: [by(cell) for cell in content["cells"]])
        if "reward" in labels:
            change(folder / "plan.json", lambda content: content.update(baseline=labels["reward"]))

    return forge


def _experiment(**told):
    return in_plan(lambda content: content["experiment"].update(told))


def _running(**told):
    return lambda folder: (folder / "running.json").write_text(json.dumps(told))


def _table(**columns):
    """The table of results, with a valid digest."""

    def forge(folder):
        pq.write_table(pa.table(columns), folder / "results.parquet")
        note_made(folder / "results.parquet")

    return forge


def _scores(columns):
    """The scores of a cell, with a valid digest."""

    def forge(folder):
        cell = first_cell(folder)
        pq.write_table(pa.table(columns(pq.read_metadata(cell / "trace.parquet").num_rows)), cell / "scores.parquet")
        note_made(cell / "scores.parquet")

    return forge


def _linked(place, to="", hard=False):
    """A link in the place of something; `to` is in the canary."""

    def forge(folder):
        path = folder / place.format(cell=first_cell(folder).name)
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        path.unlink(missing_ok=True)
        path.parent.mkdir(parents=True, exist_ok=True)
        target = folder.parent / CANARY / to
        os.link(target, path) if hard else path.symlink_to(target)

    return forge


def _put(place, content="x"):
    """A file, or a folder where there is no content, beside what is there or in its place."""

    def forge(folder):
        path = folder / place.format(cell=first_cell(folder).name)
        if content is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(content)
            return
        path.unlink(missing_ok=True)
        path.mkdir(parents=True)
        (path / "inside").write_text("kept")

    return forge


def _pipe(place):
    def forge(folder):
        path = folder / place.format(cell=first_cell(folder).name)
        path.unlink(missing_ok=True)
        path.parent.mkdir(parents=True, exist_ok=True)
        os.mkfifo(path)

    return forge


def _card(**told):
    """The card of a policy, whose digest the manifest then names."""

    def forge(folder):
        path = first_cell(folder) / "policy" / "card.json"
        path.write_text(json.dumps({**json.loads(path.read_text()), **told}))
        _name_digest(first_cell(folder), "policy/card.json")

    return forge


def _left(name, to):
    """A cell that was begun and goes on, with a file that is another one by its second name."""

    def forge(folder):
        cell = first_cell(folder)
        partial = cell.with_name(f".{cell.name}.partial")
        shutil.copytree(cell, partial)
        shutil.rmtree(cell)
        (partial / "checkpoint.safetensors").write_bytes(b"\0" * 100)
        (partial / name).unlink(missing_ok=True)
        os.link(folder.parent / CANARY / to, partial / name)

    return forge


def _gaps(rows, width):
    """Rows without a list, which take no room in a file."""
    return pa.array([None] * rows, pa.list_(pa.float64(), width))


def _with_gaps(found):
    gaps = _gaps(len(found), 10_000)
    return found.set_column(found.schema.get_field_index("qpos"), pa.field("qpos", gaps.type), gaps)


def nested(depth):
    """A list in a list, so deep."""
    value = 1
    for _ in range(depth):
        value = [value]
    return value


def _twice(content):
    content["cells"] *= 3


def _swapped(folder):
    one, other = sorted((folder / "cells").iterdir())[:2]
    one.rename(folder / "between")
    other.rename(one)
    (folder / "between").rename(other)


def _transfer(cell, name):
    def forge(folder):
        place = folder / "transfer" / cell.format(cell=first_cell(folder).name) / name
        place.mkdir(parents=True)
        told = {"format": 2, "status": "done", "reason": "", "started": "", "seconds": 0.0, "environment": {}}
        simulator = {"name": f"../{ESCAPE}", "label": ESCAPE, "params": {}}
        (place / "manifest.json").write_bytes(
            seal({**told, "files": {}, "cell": "../../x", "simulator": simulator, "policy": ""})
        )

    return forge


OUTSIDE = ("..", ".", "../..", f"../{CANARY}", f"../{CANARY}/victim", "/etc/passwd", "C:\\x", "a\\..\\..\\x")
ODD = ("\0", "x" * 300, ESCAPE, "CELLS", "Plan.json", "cafe\u0301", "\udcff")
NAMED = {"name": f"../../{CANARY}", "label": ESCAPE, "params": {}}

FORGED = {
    **{f"list: {name!r:.20}": _listed(".", name) for name in (*OUTSIDE, *ODD)},
    **{f"list of a cell: {name!r:.20}": _listed("cells/{cell}", name) for name in (*OUTSIDE[:5], *ODD[2:5])},
    **{
        f"list: {name}": _listed(".", name)
        for name in ("cells", "derived", "plan.json", "experiment.toml", ".lock", "damaged")
    },
    **{
        f"list of a cell: {name}": _listed("cells/{cell}", name)
        for name in ("manifest.json", "trace.parquet", "policy", "policy/card.json")
    },
    "list of all cells": _listed("cells", ".."),
    **{f"manifest: {name!r:.20}": _files(name) for name in (*OUTSIDE, *ODD, "", "a//b")},
    "manifest: twins": _files("Trace.parquet", "TRACE.parquet"),
    "manifest: no trace": lambda folder: change(
        first_cell(folder) / "manifest.json", lambda content: content["files"].pop("trace.parquet")
    ),
    **{f"manifest: {key}": in_manifest(**{key: ESCAPE}) for key in ("reason", "note")},
    "manifest: failed": in_manifest(status="failed", reason=f"why {ESCAPE}"),
    "manifest: environment": in_manifest(environment={"command": ESCAPE, "commit": ESCAPE, "engine": ESCAPE}),
    "manifest: sources": in_manifest(environment={"sources": {f"../{CANARY}/{EVIL}": ESCAPE}}),
    "manifest: goal": in_manifest(error=ESCAPE, unit=ESCAPE),
    "plan: cells twice": in_plan(_twice),
    "plan: no cells": in_plan(lambda content: content.update(cells=[])),
    "plan: baseline": in_plan(lambda content: content.update(baseline=ESCAPE)),
    "plan: control": in_plan(lambda content: content.update(control=[[0, 2**62], [0, 0]])),
    "plan: looks": in_plan(lambda content: content.update(terms={"looks": [1, 10**9], "race": True})),
    **{f"plan: robot {robot:.20}": _every_cell(robot=robot) for robot in (f"../{CANARY}", "/etc", "../" * 300, ESCAPE)},
    **{f"plan: {kind}": _every_cell(**{kind: NAMED}) for kind in ("simulator", "task", "algorithm", "reward")},
    **{f"label: {kind}": _relabelled(**{kind: ESCAPE}) for kind in ("simulator", "task", "algorithm", "reward")},
    **{
        f"no such {kind}": _relabelled(f"../{ESCAPE}", **{kind: ESCAPE})
        for kind in ("simulator", "task", "algorithm", "reward")
    },
    "plan: an id with a module": _every_cell(
        task={"name": "gymnasium", "label": "x", "params": {"id": f"{EVIL[:-3]}:It-v0"}}
    ),
    "plan: a program": _every_cell(task={"name": "unity", "label": "x", "params": {"file": f"../{CANARY}/program"}}),
    "experiment: plugins": _experiment(plugins=[{"path": f"../{CANARY}/{EVIL}", "name": "evil"}]),
    "experiment: plugins as text": _experiment(plugins=[f"../{CANARY}/{EVIL}"]),
    "experiment: deep": _experiment(sim=nested(DEEP)),
    "experiment: null": _experiment(sim=None),
    "experiment: half a letter": _experiment(sim="\ud800"),
    "experiment: escapes": _experiment(sim=[ESCAPE], algo=ESCAPE, reward=[{"name": ESCAPE}], measure=[ESCAPE]),
    "experiment file: escapes": _put("experiment.toml", 'sim = ["\\u001b[2J"]\nreward = 3\n'),
    "experiment file: deep": _put("experiment.toml", f"a = {'[' * DEEP}{']' * DEEP}\n"),
    "experiment file: a pipe": _pipe("experiment.toml"),
    **{
        f"running: {name!r:.20}": _running(**{name: {"started": 0.0}})
        for name in (f"../../{CANARY}", "/etc", ESCAPE, "\0")
    },
    "running: numbers": _running(x={"started": 1e308, "steps": 2**70, "success": 2}),
    "running: very many": _running(**{f"{number:016x}": {"started": 1.0} for number in range(20_000)}),
    "running: a folder": _put("running.json", None),
    "running: a pipe": _pipe("running.json"),
    "table: places": _table(id=["..", f"../../{CANARY}", "/etc", ESCAPE], status=["done"] * 4),
    "table: a long text in many rows": _table(
        id=pa.DictionaryArray.from_arrays(pa.array([0] * 50_000, pa.int32()), pa.array(["x" * 1_000_000])),
        status=["done"] * 50_000,
    ),
    "table: others": _table(a=[1]),
    "table: a pipe": _pipe("results.parquet"),
    "scores: texts": _scores(lambda rows: {ESCAPE: ["x"] * rows}),
    "scores: gaps": _scores(lambda rows: {"dense": _gaps(rows, 10_000)}),
    "scores: other rows": _scores(lambda rows: {"dense": [0.0]}),
    "trace: gaps in lists": table("trace.parquet", _with_gaps),
    "trace: one column more": table(
        "trace.parquet", lambda found: found.append_column(ESCAPE, pa.array(["x"] * len(found)))
    ),
    "trace: gaps that it has none of": _with_a_wrong_end,
    "trace: of another number of joints": table("trace.parquet", lambda found: found.drop_columns(["qpos"])),
    **{
        f"link: {place}": _linked(place)
        for place in ("cells", "cells/{cell}", "derived", "transfer", "damaged", "more")
    },
    **{
        f"link: {place}": _linked(place, "victim")
        for place in (
            "plan.json",
            "experiment.toml",
            ".lock",
            "SHA256SUMS",
            "report.html",
            "results.parquet",
            "running.json",
            "cells/{cell}/trace.parquet",
            "damaged",
        )
    },
    **{
        f"hard link: {place}": _linked(place, "victim", hard=True)
        for place in (
            *("experiment.toml", ".lock", "SHA256SUMS", "report.html", "results.parquet", "running.json", "study.log"),
            *(
                f"cells/{{cell}}/{name}"
                for name in ("manifest.json", "trace.parquet", "log.txt", "scores.parquet", "SHA256SUMS")
            ),
            *("derived/{cell}/values", "transfer/{cell}/x-0123456789ab/manifest.json"),
        )
    },
    **{
        f"link: half a {name}": _linked(f".{name}.{os.getpid()}.partial", "victim")
        for name in ("plan.json", "SHA256SUMS", "report.html", "results.parquet", "running.json")
    },
    "a begun cell: log.txt": _left("log.txt", "victim.half"),
    "a begun cell: trace.parquet": _left("trace.parquet", "victim"),
    "card: algorithm": _card(algorithm=f"../{ESCAPE}"),
    "card: kind": _card(kind=f"../{CANARY}/{EVIL}"),
    "card: cell": _card(cell={"id": "../../x", "robot": f"../{CANARY}"}),
    "card: other sizes": _card(observation={"size": 10**9}),
    "cells swapped": _swapped,
    "a cell of no name": _put("cells/notes/a.txt"),
    "a cell that is a file": _put("cells/0123456789abcdee"),
    "a cell with an escape": _put(f"cells/{ESCAPE}/manifest.json"),
    "a file more": _put("cells/{cell}/" + ESCAPE),
    "a pipe more": _pipe("cells/{cell}/pipe"),
    "a hidden folder": _put("cells/.x.partial/a.txt"),
    "damage that is a file": _put("damaged"),
    **{
        f"a folder: {name}": _put(name, None)
        for name in ("report.html", "results.parquet", "SHA256SUMS", "experiment.toml")
    },
    "derived: garbage": _put("derived/{cell}/values", ESCAPE),
    "derived: a pipe": _pipe("derived/{cell}/values"),
    "derived: a file": lambda folder: (shutil.rmtree(folder / "derived"), (folder / "derived").write_text("x")),
    "transfer: another place": _transfer("{cell}", "ideal-0123456789ab"),
    "transfer: of no cell": _transfer("notes", "ideal-0123456789ab"),
    "transfer: of no simulator": _transfer("{cell}", ESCAPE),
}
"""Ways to forge a folder, by name."""
