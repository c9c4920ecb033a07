"""Experiments that are trained in looks, made by hand."""

from dataclasses import replace

from harness import load_results
from harness.record import Store, Terms
from harness.registry import Choice
from harness.results.results import standing_of
from tests.results.folders import BASELINE_RUNS, finish
from tests.stores import create_store

CHOOSING = Terms(asked=2, budget=16)
REWARDS = ("baseline", "dense", "arp")
EPISODES = 10


class Folder:
    """An experiment with looks, of which some cells are done."""

    def __init__(self, store: Store, cells, registry) -> None:
        """Begin with nothing done."""
        self.store, self.cells, self.registry = store, cells, registry

    def train(self, reward, successes):
        """Do the next cells of a reward, with these shares of successes."""
        done = [cell for cell in self.cells[reward] if self.store.cell_folder(cell).exists()]
        for cell, share in zip(self.cells[reward][len(done) :], successes, strict=False):
            reached = round(share * EPISODES)
            finish(self.store, cell, BASELINE_RUNS[0], [True] * reached + [False] * (EPISODES - reached))

    @property
    def results(self):
        """What it says now."""
        return load_results(self.store.folder, registry=self.registry)

    @property
    def standing(self):
        """How it stands now."""
        return standing_of(self.results)


def folder_in_looks(terms, make_cell, make_plan, registry, path):
    """An experiment that trains in looks, or chooses one of two rewards with 16 trainings, nothing done yet."""
    last = terms.looks[-1] if terms.looks else 8
    choices = {name: Choice(name, (), name) for name in REWARDS}
    cells = {name: [make_cell(seed=100 + seed, reward=it) for seed in range(last)] for name, it in choices.items()}
    if terms.budget:
        del cells["baseline"][: last // 2]  # it is no candidate
    in_order = sorted((cell for of in cells.values() for cell in of), key=lambda cell: cell.seed)
    store = create_store(path, replace(make_plan(*in_order), terms=terms))
    return Folder(store, cells, registry)
