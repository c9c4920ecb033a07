"""Large experiments for the price of eight trainings: real cells, copied under other seeds and other rewards.

Run as a program it leaves the two folders that ``docs/performance.md`` measures::

    python tests/copied_cells.py REAL OUT
"""

import json
import os
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from harness import load_registry
from harness.executor import Cell
from harness.experiment.followed import EndedCells
from harness.files.bounded import read_keyed, seal, with_key
from harness.record import (
    CELLS,
    DERIVED,
    EVALUATION,
    MANIFEST,
    POLICY,
    RANDOM,
    TRACE,
    Manifest,
    Store,
    read_manifest,
    read_trace,
)
from harness.record.cell import digests_in
from harness.record.plan_file import StoredPlan
from harness.registry import Choice, Registry, choose
from harness.results.kept import FORMAT, LARGEST
from harness.score.scorer import pay_log

PAID = (TRACE, EVALUATION, "stochastic.parquet", RANDOM)
"""Files with a column of what the cell's reward paid."""


class Copier:
    """Copies done cells of one experiment into another one; all copies of a training share its files on the disk."""

    def __init__(self, real: Path, into: Path, registry: Registry) -> None:
        self._into, self._registry = into, registry
        self._sources = [read_manifest(path.parent) for path in sorted((real / CELLS).glob(f"[!.]*/{MANIFEST}"))]
        self._real = Store(real)
        self._paid: dict[tuple[str, Choice], Path] = {}
        self._cells: list[Cell] = []
        (into / CELLS).mkdir(parents=True)

    def copy(self, trained_with, reward, seeds, trainings):
        """Cells that were paid `reward` in place of the one with the label `trained_with`, from so many trainings."""
        sources = [it for it in self._sources if it.status == "done" and it.cell.reward.label == trained_with]
        for number, seed in enumerate(seeds):
            source = sources[number % min(trainings, len(sources))]
            self._leave(self._paid_by(source.cell, reward), replace(source, cell=_with(source.cell, reward, seed)))

    def finish(self, baseline):
        """Write the plan of all copies."""
        StoredPlan(baseline, False, {}, tuple(self._cells)).write(self._into)
        shutil.rmtree(self._into / "paid")

    def _paid_by(self, cell, reward):
        """The folder of a real cell, its rows paid by another reward."""
        key = (cell.id, reward)
        if key not in self._paid:
            folder = self._into / "paid" / f"{len(self._paid)}"
            shutil.copytree(self._real.cell_folder(cell), folder)
            (folder / MANIFEST).unlink()
            if reward != cell.reward:
                built = reward.build(self._registry, "rewards")
                for name in PAID:
                    _pay(folder / name, built)
            self._paid[key] = folder
            self._digests = digests_in(folder)
            (folder / MANIFEST).write_text(json.dumps(self._digests))
        return self._paid[key]

    def _leave(self, paid, manifest):
        folder = self._into / CELLS / manifest.cell.id
        shutil.copytree(paid, folder, copy_function=os.link)
        files = json.loads((folder / MANIFEST).read_text())
        card = folder / POLICY / "card.json"
        told = {**json.loads(card.read_text()), "cell": manifest.cell.to_json()}
        for path in (card, folder / MANIFEST):
            path.unlink()  # a link: its content belongs to the others too
        card.write_text(json.dumps(told, indent=1))
        _write(folder, manifest, files)
        self._cells.append(manifest.cell)


def _write(folder, manifest, files):
    """The manifest; of the files that are linked the digests are known."""
    card = f"{POLICY}/card.json"
    record = replace(manifest, files={**files, card: digests_in(folder / POLICY)["card.json"]})
    (folder / MANIFEST).write_bytes(seal({"format": Manifest.FORMAT, **record.to_json()}))


def _with(cell, reward, seed):
    return replace(cell, reward=reward, seed=seed)


def _pay(path, reward):
    """What `reward` would have paid, in place of what was."""
    if not path.is_file():
        return
    paid = pay_log(reward, read_trace(path)).total
    with pq.ParquetFile(path) as file:
        table, facts = file.read(), file.metadata.metadata
    table = table.set_column(table.schema.get_field_index("reward"), "reward", pa.array(paid))
    facts = {key: value for key, value in facts.items() if key != b"ARROW:schema"}
    with pq.ParquetWriter(path, table.schema, compression="zstd") as writer:
        writer.write_table(table, row_group_size=16_384)
        writer.add_key_value_metadata(facts)


def copy_experiment(real, into, proposed, seeds, registry, trainings=4):
    """An experiment of a baseline and `proposed` rewards, ``arp:k2=1.01``, over `seeds` seeds each.

    Args:
        real: An experiment with trainings under ``baseline`` and ``arp``.
        into: The folder to make.
        proposed: The rewards; all are paid for what ``arp`` taught.
        seeds: Of each reward.
        registry: The plugins.
        trainings: Of each reward so many real ones are copied.
    """
    copier = Copier(real, into, registry)
    copier.copy("baseline", choose(registry, "rewards", "baseline"), range(seeds), trainings)
    for text in proposed:
        copier.copy("arp", choose(registry, "rewards", text), range(seeds), trainings)
    copier.finish("baseline")


def keep_as_a_run_does(folder, registry):
    """Make what is kept of each cell as it ends; copies of one training get copies of it."""
    store, plan = Store(folder), Store(folder).read_plan()
    ended = EndedCells(store, registry)
    first = {}
    for cell in plan.cells:
        known = first.setdefault(((store.cell_folder(cell) / TRACE).stat().st_ino, cell.reward.label), cell)
        if known is cell:
            ended.keep(read_manifest(store.cell_folder(cell)))
        else:
            _copy_kept(folder / DERIVED, known.id, cell.id)


def _copy_kept(derived, known, other):
    (derived / other).mkdir(parents=True)
    for path in (derived / known).iterdir():
        name = path.stem.partition("-")[2]
        keys = [f"{FORMAT} {owner} {name}".strip() for owner in (known, other)]
        content = read_keyed(path, keys[0], LARGEST)
        assert content is not None, path
        (derived / other / path.name).write_bytes(with_key(keys[1], content))


def many_rewards(count):
    """``arp:k2=1.01`` and so on."""
    return [f"arp:k2={1.01 + number / 100:.2f}" for number in range(count)]


if __name__ == "__main__":
    real, out = map(Path, sys.argv[1:])
    plugins = load_registry()
    for name, rewards, count in (("one", ["arp"], 500), ("fifty", many_rewards(49), 20)):
        if not (out / name).exists():
            copy_experiment(real, out / name, rewards, count, plugins)
        shutil.rmtree(out / name / DERIVED, ignore_errors=True)
        keep_as_a_run_does(out / name, plugins)
