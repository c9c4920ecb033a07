"""What was asked for in an experiment's folder: ``plan.json``, and ``experiment.toml``, which people read."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, Self

import tomli_w
from pydantic import AfterValidator, BeforeValidator, Field, with_config

import harness.record.file_forms as forms
from harness.errors import SchemaError, UsageError, one_line
from harness.files.bounded import read_sealed, reading, seal, unseal, write_whole
from harness.record.cell import Cell
from harness.record.terms import FIRST, Terms
from harness.registry.toml_file import MOST_DEPTH, depth_of, read_toml

EXPERIMENT, PLAN = "experiment.toml", "plan.json"
FORMAT = SEALED_SINCE = 2
"""Format 1, of version 0.1, has no digest."""
PLAN_BYTES = 2**28
"""Most that is read of a plan: 100,000 cells of 2,600 bytes each."""
LISTS = ("sim", "algo", "reward")
"""Keys of an experiment that hold names; each multiplies the cells, as ``seeds`` does."""


BESIDE = ("format", "experiment_digest")
"""Keys of the file that tell nothing of the plan; that digest stands in plans of earlier versions."""


def _writable(experiment: dict[str, Any]) -> dict[str, Any]:
    if depth_of(experiment) > MOST_DEPTH:
        raise ValueError(f"is nested more than {MOST_DEPTH} deep")
    try:
        tomli_w.dumps(experiment).encode()
    except (TypeError, ValueError):  # null, or half a character
        raise ValueError("holds a value that no experiment file has") from None
    return experiment


@with_config(forms.EXACT)
@dataclass(frozen=True, eq=False)
class StoredPlan:
    """What was asked for in an experiment's folder.

    Attributes:
        baseline: Label of the reward that the others are compared with.
        a_a: Whether the newest experiment compares the baseline with itself.
        control: By each seed the other seed that the baseline is trained with again for that.
        cells: Of all experiments that were run here.
        experiment: The newest one, every default filled in.
        note: Of one that was put together from the cells of a damaged one: why. Nobody knows what is missing then, so
            every reader says it, and no verdict is given. It stays with the plan until a run asks for all those cells.
        terms: What was agreed on before the first training.
    """

    baseline: forms.Name
    a_a: bool
    control: Annotated[Mapping[forms.Whole, forms.Whole], BeforeValidator(dict)]
    cells: Annotated[
        tuple[Cell, ...], Field(max_length=forms.MOST_CELLS), AfterValidator(lambda cells: tuple(dict.fromkeys(cells)))
    ]
    experiment: Annotated[Mapping[forms.Name, Any], AfterValidator(_writable)] = field(default_factory=dict)
    note: forms.Line = ""
    terms: Terms = FIRST

    def with_cells_of(self, earlier: Sequence[Cell]) -> Self:
        """The same, behind the cells that were asked for before: a folder grows, nothing is lost.

        Raises:
            UsageError: Together they are too many: nobody could read the plan again.
        """
        cells: dict[Cell, Cell] = {}
        for cell in (*earlier, *self.cells):
            # The traces of a cell that was asked for twice keep what either plan asks for.
            records = dict.fromkeys((*cells.get(cell, cell).records, *cell.records))
            cells[cell] = replace(cell, records=tuple(records))
        if len(cells) > forms.MOST_CELLS:
            raise UsageError(
                f"{len(earlier):,} cells that are there and those that are asked for are {len(cells):,}, "
                f"{forms.MOST_CELLS:,} are allowed in one folder. Name another folder"
            )
        return replace(self, cells=tuple(cells.values()))

    def write(self, folder: Path) -> None:
        """Write both files; ``plan.json``, which says all, comes first.

        Raises:
            OSError: One cannot be written; each is there as it was before, or as it is now.
            UsageError: Nobody could read it again. Nothing is written.
        """
        try:
            content = seal({
                "format": FORMAT,
                "baseline": self.baseline,
                "a_a": self.a_a,
                "control": [list(pair) for pair in self.control.items()],
                "experiment": self.experiment,
                "terms": self.terms.to_json(),
                "cells": [cell.to_json() for cell in self.cells],
                **({"note": self.note} if self.note else {}),
            })  # fmt: skip
            if len(content) > PLAN_BYTES:
                raise ValueError(f"it has {len(content):,} bytes, {PLAN_BYTES:,} are allowed")
            _plan_of(unseal(content))
        except (ValueError, TypeError, RecursionError) as error:  # of what a stranger's plan, or a flag, told
            raise UsageError(
                f"'{folder}' cannot hold what is asked for, nobody could read its {PLAN} again: {one_line(error)}"
            ) from None
        write_whole(folder / PLAN, content)
        write_whole(folder / EXPERIMENT, self.experiment_text)

    @property
    def experiment_text(self) -> str:
        """The newest experiment as an experiment file."""
        return tomli_w.dumps(self.experiment)


def read_plan(folder: Path) -> StoredPlan:
    """The plan in a folder.

    Raises:
        SchemaError: It is damaged or written by a newer version.
    """
    path = folder / PLAN
    data = read_sealed(path, "plan", FORMAT, SEALED_SINCE, PLAN_BYTES)
    with reading(path, "plan"):
        return _plan_of(data if data.get("experiment", {}) != {} else {**data, "experiment": experiment_in(folder)})


def _plan_of(data: dict[str, Any]) -> StoredPlan:
    told = {name: it for name, it in data.items() if name not in BESIDE}
    found = forms.read_form(StoredPlan, {"control": [], **told})  # a plan of version 0.1 has none
    if not found.terms.race:
        return found
    # Whoever looked at a race once and trained on gave luck a second chance.
    return replace(found, terms=replace(found.terms, looks=(), grown=found.terms.looks[:1]))


def plan_from_cells(folder: Path, cells: Iterable[Cell], damage: str) -> StoredPlan:
    """The plan that cells and ``experiment.toml`` tell of, where ``plan.json`` is damaged.

    Cells that had not begun are not known any more; the same command as before asks for them again.

    Args:
        folder: The experiment's.
        cells: Those that left a manifest.
        damage: What is wrong with the file.

    Raises:
        SchemaError: Neither says what the baseline is.
    """
    known = tuple(sorted(cells, key=lambda cell: (cell.seed, cell.id)))
    experiment = experiment_in(folder)
    labels = {cell.reward.label for cell in known}
    baseline = _label(experiment.get("baseline", "baseline"), known)
    if baseline not in labels:
        raise SchemaError(
            f"{damage}. The cells have the rewards {', '.join(sorted(labels)) or '(none)'}, and "
            f"{EXPERIMENT} does not say which of them is the baseline: run the same command as before"
        )
    rewards = [_label(reward, known) for reward in experiment.get("reward", [])]
    seeds = _with_seed_list(experiment).get("seeds")
    if not isinstance(seeds, list):
        seeds = sorted({cell.seed for cell in known})
    control = control_seeds(seeds) if baseline in rewards else {}
    note = f"{damage}. The plan was put together from {len(known)} cells; run the same command as before to mend it"
    return StoredPlan(baseline, bool(control), control, known, experiment, note)


def control_seeds(seeds: Sequence[int]) -> dict[int, int]:
    """For each seed another one, none of which the experiment has: the null control's."""
    beyond = max(seeds) + 1
    return {seed: seed + beyond for seed in seeds}


def experiment_in(folder: Path) -> dict[str, Any]:
    """The newest experiment as ``experiment.toml`` tells it; empty where that cannot be read."""
    try:
        return read_toml(folder / EXPERIMENT, "experiment file")
    except UsageError:  # damaged too, or gone: the cells are all that there is
        return {}


def _label(given: Any, cells: Sequence[Cell]) -> str:
    """The label of the reward that an experiment file names, as `harness.registry.choice.Choice.to_json` wrote it."""
    for reward in (cell.reward for cell in cells):
        params = reward.to_json()["params"].items()
        if {"name": reward.name, **{key: value for key, value in params if value is not None}} == given:
            return reward.label
    return str(given["name"] if isinstance(given, dict) and "name" in given else given)


def unite(plans: Sequence[tuple[Path, StoredPlan]]) -> StoredPlan:
    """The plan of all cells.

    Where the experiments differ in one of their lists alone, the experiment is the one that asks for all of it, and the
    cells come in its order. Else it is the last one, as in a folder where one experiment was run after the other.

    Args:
        plans: Each with the folder that it stands in.

    Raises:
        UsageError: They have several baselines, or some are in an environment and others are not.
    """
    (first, whole), *others = plans
    for folder, plan in others:
        if plan.baseline != whole.baseline:
            raise UsageError(
                f"'{first}' compares with {whole.baseline}, '{folder}' with {plan.baseline}: "
                "only experiments with one baseline can be merged"
            )
        refuse_mixed(f"'{first}' and '{folder}'", whole.cells, plan.cells)
        experiment = _experiment_of_both(whole, plan)
        whole = replace(
            plan,
            control={**whole.control, **plan.control},
            a_a=whole.a_a or plan.a_a,
            terms=_terms_of_both(whole.terms, plan.terms),
            note="; ".join(dict.fromkeys(filter(None, (whole.note, plan.note)))),
        ).with_cells_of(whole.cells)
        if experiment:
            whole = replace(whole, cells=_in_order(whole), experiment=experiment)
    return whole


def refuse_mixed(where: str, cells: Iterable[Cell], others: Iterable[Cell]) -> None:
    """See that all cells are made of the same kinds of plugins: an environment has none of what an arm has.

    Raises:
        UsageError: It is not so.
    """
    if len({tuple(cell.plugins) for cell in (*cells, *others)}) > 1:
        raise UsageError(
            f"{where}: an experiment in an environment and one with a robot of the harness do not go into one folder. "
            "Name another"
        )


def _terms_of_both(one: Terms, other: Terms) -> Terms:
    """What both agreed on; `FIRST` where that is not the same. What was added later to either stays told."""
    later: dict[str, Any] = {
        "grown": tuple(sorted({*one.grown, *other.grown})),
        "joined": tuple(dict.fromkeys((*one.joined, *other.joined))),
    }
    agreed, theirs = replace(one, **later), replace(other, **later)
    return agreed if agreed == theirs else replace(FIRST, **later)


def _experiment_of_both(one: StoredPlan, other: StoredPlan) -> dict[str, Any]:
    """The experiment that asks for the cells of both; empty where no single one does."""
    first, second = _with_seed_list(one.experiment), _with_seed_list(other.experiment)
    differing = [key for key in {**first, **second} if first.get(key) != second.get(key)]
    if not differing:
        return first
    key, *more = differing
    if more or key not in (*LISTS, "seeds") or not all(isinstance(it.get(key), list) for it in (first, second)):
        return {}
    items = [*first[key], *(item for item in second[key] if item not in first[key])]
    return {**second, key: sorted(items) if key == "seeds" else items}


def _with_seed_list(experiment: Mapping[str, Any]) -> dict[str, Any]:
    """The experiment with its seeds one by one; a number of seeds that no experiment has stays a number."""
    seeds = experiment.get("seeds")
    if not isinstance(seeds, int) or seeds > forms.MOST_SEEDS:
        return dict(experiment)
    return {**experiment, "seeds": [*range(seeds)]}


def _in_order(plan: StoredPlan) -> tuple[Cell, ...]:
    """Cells in the order in which one experiment has them: seeds outermost, the null control's last."""
    chosen = {cell: (cell.place, cell.algorithm, cell.reward) for cell in plan.cells}
    ranks = [*dict.fromkeys(chain.from_iterable(chosen.values()))]
    others = set(plan.control.values()) - set(plan.control)

    def rank(cell: Cell) -> tuple[int, ...]:
        is_control = cell.seed in others and cell.reward.label == plan.baseline
        return (is_control, cell.seed, *map(ranks.index, chosen[cell]))

    return tuple(sorted(plan.cells, key=rank))
