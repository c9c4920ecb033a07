"""Folders of experiments, of which each cell's numbers are known, and what a stranger may make of them.

Traces are those of one unfinished episode, so that the curve of a run is the sum of what is worked out here.
"""

import json
import shutil
from dataclasses import dataclass

import pyarrow as pa
import pyarrow.parquet as pq

from harness.executor import Cell
from harness.experiment.plan import Plan
from harness.files.bounded import digest_of
from harness.record import EVALUATION, MANIFEST, TRACE
from harness.registry import Choice
from tests.cli.forging import change as sealed_again
from tests.oracles.answers import Row, accelerated, etas, indices
from tests.oracles.trial import Shown, Trial, call, call_json
from tests.results.folders import finish
from tests.stores import create_store

BASELINE, ARP = Choice("baseline", (), "baseline"), Choice("arp", (("k1", 1.0), ("k2", 1.5)), "arp")
K2 = {"baseline": 1.0, "arp": 1.5}
EPISODES, UNIT = 4, 1 / 32


@dataclass
class Done:
    """A cell and what it left."""

    cell: Cell
    distances: list[float]
    rewards: list[float]
    reached: list[bool]


def draw(rng, seeds=None):
    """Some seeds of both rewards."""
    count, steps = rng.randrange(1, 5) if seeds is None else seeds, rng.randrange(4, 30)
    return [_draw_cell(rng, reward, seed, steps) for seed in range(count) for reward in (BASELINE, ARP)]


def _draw_cell(rng, reward, seed, steps):
    distances = [UNIT * rng.randrange(20, 40)]
    while len(distances) < steps:
        distances.append(max(UNIT, distances[-1] + UNIT * rng.randrange(-6, 6)))
    rows = [Row(distances[0], distance, place == 0) for place, distance in enumerate(distances)]
    sim, task, algorithm = (Choice(name, (), name) for name in ("kinematic", "fd100-reach", "random"))
    cell = Cell(sim, "fd100", task, algorithm, reward, seed, steps, EPISODES)
    reached = [rng.random() < 0.5 for _ in range(EPISODES)]
    return Done(cell, distances, accelerated(rows, 1.0, K2[reward.label]), reached)


def write(cells, folder, plan=None):
    """The folder of an experiment; of a plan that may have more cells."""
    planned = tuple(done.cell for done in plan or cells)
    store = create_store(folder, Plan(BASELINE.label, planned, (), {"sim": ["kinematic"], "algo": ["random"]}, {}))
    for done in cells:
        finish(store, done.cell, done.distances, done.reached, [False] * EPISODES, done.rewards)
    return folder


def answer_of(cells, behaving=()):
    """What a report has to say.

    Args:
        cells: Those whose pay is compared.
        behaving: Those whose success is compared, where they are more: a training whose seed the other reward lacks.
    """
    acting = {name: [done for done in behaving or cells if done.cell.reward.label == name] for name in K2}
    groups = {name: [done for done in cells if done.cell.reward.label == name] for name in K2}
    runs = {name: [done.rewards for done in group] for name, group in groups.items()}
    eta_n, eta_p = etas(*runs.values())
    told = {"eta_N": eta_n, "eta_P": eta_p}
    for name in groups:
        below, above = indices(runs[name])
        reached = [sum(done.reached) / EPISODES for done in acting[name]]
        told[name] = {"I_N": Shown(below), "I_P": Shown(above), "success": sum(reached) / len(reached)}
    return told


def reduced(told):
    """What is compared of ``report --json``."""
    (one,) = told["combinations"]
    (success,) = (
        metric for metric in one["behaviour"] if metric["name"] == "success_rate" and metric["baseline"] is not None
    )
    who = {"baseline": one["baseline"], "proposed": one["proposed"]}
    return {
        "eta_N": one["eta_N"]["eta"]["value"],
        "eta_P": one["eta_P"]["eta"]["value"],
        **{
            name: {**{key: one[f"{side}_index"][key] for key in ("I_N", "I_P")}, "success": success[side]}
            for side, name in who.items()
        },
    }


def ask(folder):
    """What `harness report` says."""
    told, said = call_json("report", folder)
    return reduced(told), said


def cells_in(folder):
    """The folders of its cells."""
    return sorted((folder / "cells").iterdir())


def rewrite(cell, name, by, is_sealed=True, **how):
    """Another table in a cell, and its digest in the manifest."""
    pq.write_table(by(pq.read_table(cell / name)), cell / name, **how)
    if is_sealed:
        sealed_again(cell / MANIFEST, lambda content: content["files"].update({name: digest_of(cell / name)}))


def no_matter(rng, folder):
    """The same numbers, written otherwise, or with lies beside them that nothing should believe."""
    cells = draw(rng)
    experiment = write(cells, folder / "it")
    change = rng.choice(BESIDE)
    change(experiment, rng)
    return Trial(change.__name__, lambda: ask(experiment), [answer_of(cells)])


def packed_otherwise(folder, rng):
    """Traces are compressed in another way, in other pieces."""
    for cell in cells_in(folder):
        how = {"compression": rng.choice(("none", "gzip", "snappy")), "row_group_size": rng.choice((1, 5, 1_000))}
        rewrite(cell, rng.choice((TRACE, EVALUATION)), lambda table: table, **how)


def keys_in_another_order(folder, rng):
    """The keys of manifests and of the plan."""

    def shuffle(content):
        items = list(content.items())
        rng.shuffle(items)
        content.clear()
        content.update(items)

    for path in (folder / "plan.json", *(cell / MANIFEST for cell in cells_in(folder))):
        sealed_again(path, shuffle)


def lies_in_derived(folder, rng):
    """What an earlier report kept is changed: it follows from the cells, and not the other way around."""
    call("report", folder, "--json")
    for path in [path for path in folder.rglob("*") if path.is_file() and "derived" in path.parts]:
        text = path.read_bytes()
        place = rng.randrange(len(text))
        path.write_bytes(text[:place] + bytes([text[place] ^ 1]) + text[place + 1 :])


def derived_of_another(folder, rng):
    """What a report of another experiment kept lies in this one."""
    other = write(draw(rng), folder.parent / "other")
    call("report", folder, "--json")
    call("report", other, "--json")
    if (other / "derived").is_dir():
        shutil.rmtree(folder / "derived", ignore_errors=True)
        shutil.copytree(other / "derived", folder / "derived")


def lies_in_results(folder, rng):
    """A table of all results, with its digest in the list, says other numbers."""
    call("report", folder, "--json")
    path = folder / "results.parquet"
    pq.write_table(pa.table({"eta_N": [7.0], "cell": ["x"]}), path)
    (folder / "SHA256SUMS").write_text(f"# harness made these files from others\n{digest_of(path)}  {path.name}\n")


def odd_files(folder, rng):
    """Files and folders that nobody made."""
    (folder / "notes.txt").write_text("mine")
    (folder / "cells" / ".DS_Store").write_bytes(b"\0")
    (folder / "running.json").write_text(rng.choice(("{}", '{"pid": 1}', "x")))


BESIDE = (packed_otherwise, keys_in_another_order, lies_in_derived, derived_of_another, lies_in_results, odd_files)


def matters(rng, folder):
    """Other numbers, sealed again, after a report has kept the earlier ones: the answer follows."""
    cells = draw(rng)
    experiment = write(cells, folder / "it")
    if rng.random() < 0.7:
        call("report", experiment, "--json")
    done = rng.choice(cells)
    place = next(cell for cell in cells_in(experiment) if done.cell.id in cell.name)
    change = rng.choice(("reward", "outcome"))
    if change == "reward":
        row, value = rng.randrange(1, len(done.rewards)), rng.choice((-32.0, 32.0))
        done.rewards[row] = value
        rewrite(place, TRACE, lambda table: _with(table, "reward", row, value))
    else:
        row = rng.randrange(EPISODES)
        value = not done.reached[row]
        done.reached[row] = value
        rewrite(place, EVALUATION, lambda table: _turned(table, row, value))
    return Trial(f"another {change}", lambda: ask(experiment), [answer_of(cells)], True)


def _with(table, name, row, value):
    values = table.column(name).to_pylist()
    values[row] = value
    place = table.schema.get_field_index(name)
    return table.set_column(place, table.schema.field(name), pa.array(values, table.schema.field(name).type))


def _turned(table, row, value):
    for name, told in (("reached", value), ("terminated", value), ("truncated", not value)):
        kind = table.schema.field(name).type
        table = _with(table, name, row, told if pa.types.is_boolean(kind) else float(told))
    return table


def damaged(rng, folder):
    """A cell is not what was written: it is left out and told, and `verify` names it."""
    cells = draw(rng, rng.randrange(2, 5))
    experiment = write(cells, folder / "it")
    done = rng.choice(cells)
    place = next(cell for cell in cells_in(experiment) if done.cell.id in cell.name)
    change = rng.choice(list(DAMAGES))
    DAMAGES[change](place, rng)
    # the other of its seed is left out with it where pay is compared, which is so seed by seed
    alone = [other for other in cells if other is not done]
    paired = [other for other in cells if other.cell.seed != done.cell.seed]

    def look():
        found, _ = call_json("verify", experiment)
        # a lie with a valid digest is none that a digest shows
        assert "sealed" in change or place.name in json.dumps(found), f"verify does not name {place.name}: {found}"
        return ask(experiment)

    return Trial(change, look, [answer_of(paired, alone)], True, r"(?i)damaged")


def _of_another(name):
    """A file, or all of them, sealed, are those of another cell."""

    def change(cell, rng):
        other = rng.choice([path for path in cell.parent.iterdir() if path != cell])
        if name:
            shutil.copy(other / name, cell / name)
        else:
            shutil.rmtree(cell)
            shutil.copytree(other, cell)

    return change


def _flip(cell, rng):
    """One bit of the trace."""
    text = bytearray((cell / TRACE).read_bytes())
    text[rng.randrange(len(text))] ^= 1
    (cell / TRACE).write_bytes(bytes(text))


DAMAGES = {
    "another reward, its digest kept": lambda cell, rng: rewrite(
        cell, TRACE, lambda table: _with(table, "reward", 1, 9.0), is_sealed=False
    ),
    "a bit": _flip,
    "a trace that is gone": lambda cell, rng: (cell / TRACE).unlink(),
    "another cell's manifest": _of_another(MANIFEST),
    "another cell's files": _of_another(""),
    "another cell's trace": _of_another(TRACE),
    "NaN in the rewards, sealed": lambda cell, rng: rewrite(
        cell, TRACE, lambda table: _with(table, "reward", 1, float("nan"))
    ),
    "another seed in the manifest, sealed": lambda cell, rng: sealed_again(
        cell / MANIFEST, lambda content: content["cell"].update(seed=77)
    ),
    "another reward in the manifest, sealed": lambda cell, rng: sealed_again(
        cell / MANIFEST, lambda content: content["cell"]["reward"].update(name="dense", label="dense")
    ),
}


def merged(rng, folder):
    """The cells of one experiment in two folders, some in both, put together again."""
    cells = draw(rng, rng.randrange(2, 5))
    cut = rng.randrange(1, len(cells))
    again = rng.randrange(cut + 1)
    write(cells[:cut], folder / "one", plan=cells)
    write(cells[cut - again :], folder / "other", plan=cells)
    names = rng.sample(["one", "other"], 2)

    def look():
        call("merge", *(folder / name for name in names), "--out", folder / "all")
        return ask(folder / "all")

    return Trial("put together again", look, [answer_of(cells)])


ORACLES = {
    "experiment, written otherwise": no_matter,
    "experiment, other numbers": matters,
    "experiment, damaged": damaged,
    "experiment, merged": merged,
}
