"""Folders of experiments whose plan is written down, and of which no cell has begun."""

from harness.record import Store


def create_store(folder, plan):
    """Make an experiment's folder and add a plan to it."""
    store = Store.claim(folder)
    with store.locked():
        store.add(plan)
    return store
