"""Readers that are broken on purpose, each as a reader has been broken before: an oracle finds every one."""

import importlib
import itertools

import numpy as np
import pytest

from harness.eta import GroupCurve
from harness.payoff.dataset.paid_dataset import Fingerprint
from harness.policy import kinds
from harness.policy.policy import ACTIVATIONS
from harness.record import cell
from harness.record.dataset.labels import SuccessRule
from harness.record.recording import recorded_training
from harness.robot import kinematics
from harness.score import scorer
from harness_plugins.datasets.steps import Source
from tests.oracles import settings
from tests.oracles.test_oracles import faults_of

lerobot = importlib.import_module("harness_plugins.logs.lerobot")
TRIED = 24
"""So many inputs are tried before a mutant counts as missed."""


def _columns(patch, change):
    columns = Source.columns

    def changed(self, names, steps, told):
        return {name: change(name, values, steps) for name, values in columns(self, names, steps, told).items()}

    patch.setattr(Source, "columns", changed)


def _last_frame_is_not_paid(patch):
    _columns(patch, lambda name, of, steps: np.where(steps.ends, 0.0, of) if name.startswith("reward/") else of)


def _label_is_whatever_is_not_zero(patch):
    patch.setattr(SuccessRule, "of_steps", lambda self, values, noun: np.asarray(values, bool).ravel().astype(np.int8))


def _tasks_are_pooled(patch):
    _columns(patch, lambda name, of, steps: np.full(len(of), "", object) if name == "task" else of)


def _copies_are_counted(patch):
    number = itertools.count()
    patch.setattr(Fingerprint, "digest", lambda self: str(next(number)).encode())


def _metadata_are_not_believed(patch):
    for module in (lerobot, importlib.import_module("harness_plugins.logs.minari")):
        patch.setattr(module, "take_census", lambda path, found, **declared: (frozenset(found), []))


def _frames_come_in_any_order(patch):
    patch.setattr(lerobot, "_require_order", lambda path, frames, begun, goes_on: None)


def _last_step_is_not_summed(patch):
    add = GroupCurve._add_mean
    patch.setattr(GroupCurve, "_add_mean", lambda self, mean: add(self, mean[:-1]))


def _best_distance_stays_the_first(patch):
    rows_of = scorer.field_rows

    def first(run, fields):
        rows = rows_of(run, fields)
        return {**rows, "previous_best": rows["begin_distance"]}

    patch.setattr(scorer, "field_rows", first)


def _angles_turn_the_other_way(patch):
    turned = kinematics._rotation_from_rpy
    patch.setattr(kinematics, "_rotation_from_rpy", lambda rpy: turned(rpy).T)


def _steps_may_be_missing(patch):
    patch.setattr(recorded_training, "_require_unbroken", lambda folder, columns, last: last)


def _digests_are_not_looked_at(patch):
    patch.setattr(cell, "require_files", lambda folder, record: None)


def _relu_for_tanh(patch):
    patch.setitem(ACTIVATIONS, "tanh", ACTIVATIONS["relu"])


def _cards_are_not_compared(patch):
    patch.setattr(kinds, "_require_told", lambda card, policy: None)


def _last_cell_is_lost(patch):
    expand = settings.expand

    def shorter(*given):
        plan = expand(*given)
        object.__setattr__(plan, "cells", plan.cells[:-1])
        return plan

    patch.setattr(settings, "expand", shorter)


MUTANTS = (
    (_last_frame_is_not_paid, "lerobot, written otherwise"),
    (_label_is_whatever_is_not_zero, "lerobot, other episodes"),
    (_label_is_whatever_is_not_zero, "minari, other episodes"),
    (_tasks_are_pooled, "lerobot, written otherwise"),
    (_copies_are_counted, "lerobot, copies"),
    (_copies_are_counted, "minari, copies"),
    (_metadata_are_not_believed, "lerobot, damaged"),
    (_metadata_are_not_believed, "minari, totals"),
    (_frames_come_in_any_order, "lerobot, damaged"),
    (_last_step_is_not_summed, "csv, other numbers"),
    (_best_distance_stays_the_first, "csv, paid again"),
    (_angles_turn_the_other_way, "arm, written otherwise"),
    (_steps_may_be_missing, "recording, damaged"),
    (_relu_for_tanh, "policy"),
    (_cards_are_not_compared, "policy"),
    (_last_cell_is_lost, "experiment file"),
)


SLOW = pytest.param(_digests_are_not_looked_at, "experiment, damaged", marks=pytest.mark.slow)


def _found(name, folder):
    for seed in range(TRIED):
        own = folder / f"at-{seed}"
        own.mkdir()
        yield bool(faults_of(name, [seed], own))


@pytest.mark.parametrize(("mutant", "name"), [*MUTANTS, SLOW], ids=lambda given: getattr(given, "__name__", given))
def test_a_broken_reader_is_found(mutant, name, monkeypatch, tmp_path):
    """Within a few inputs."""
    mutant(monkeypatch)
    assert any(_found(name, tmp_path))
