"""Success from outside: a CSV file that says which trainings, or which of their episodes, were successes."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from harness.errors import UsageError
from harness.log import LogFacts, in_memory
from harness.log.log import BEHAVIOUR, SUCCESS
from harness.record.dataset.labels import UNKNOWN, WHOLE, SuccessRule, read_labels
from harness.results.logs.trainings import Sorted, Training

COLUMN = f"{BEHAVIOUR}{SUCCESS}"
RULE = SuccessRule("success")
LABELS = "labels"
"""The format of what a user says of whole trainings."""


def labelled(found: Sorted, folder: Path, path: Path) -> Sorted:
    """The trainings with the success that a file tells.

    The file has the columns ``run`` and ``success``, a line for each training; with a column ``episode``, counted from
    0, a line for each episode. ``run`` is the path of a log below the folder, or ``REWARD/SEED``. Where there is one
    training, ``run`` may be left out.

    Raises:
        UsageError: The file cannot be read, or a run or an episode of it is not there, or it leaves some out.
    """
    labels = read_labels(path, RULE, len(found.trainings))
    names = {training: _names(training, folder) for training in found.trainings}
    of = {it: [labels[name] for name in called if name in labels] for it, called in names.items()}
    unknown = labels.keys() - {name for called in names.values() for name in called}
    if unknown:
        shown = ", ".join(f"'{it.reward}/{it.seed}'" for it in found.trainings[:3])
        raise UsageError(f"--labels {path}: no training is called '{min(unknown)}'; they are called {shown}, ...")
    twice = next((training for training, it in of.items() if it[1:]), None)
    if twice:
        raise UsageError(f"--labels {path} calls {twice.shown} by two names: leave one out")
    without = [training for training, it in of.items() if not it]
    if without:
        raise UsageError(
            f"--labels {path} says nothing of {len(without)} of {len(of)} trainings, such as {without[0].shown}"
        )
    told = tuple(_with_success(training, it[0], path) for training, it in of.items())
    return found._replace(trainings=told, notes=(*found.notes, f"Success is what '{path}' says"))


def _names(training: Training, folder: Path) -> set[str]:
    """What it may be called; nothing where it is the only one."""
    path = training.path
    below = path.relative_to(folder) if path.is_relative_to(folder) else path
    return {"", f"{training.reward}/{training.seed}", below.as_posix(), training.facts.run}


def _with_success(training: Training, labels: Mapping[int, int], path: Path) -> Training:
    log, is_whole = training.logs[0], WHOLE in labels
    if not is_whole and len(training.logs) > 1:
        raise UsageError(
            f"--labels {path}: the {len(training.logs)} files of {training.shown} number no episodes together"
        )
    numbers = [WHOLE] if is_whole else range(len(log))
    lacking = next((it for it in numbers if it not in labels), None)
    if lacking is not None or len(labels) > len(numbers):
        told = f"lacks episode {lacking}" if lacking is not None else f"has {len(labels):,} episodes"
        raise UsageError(f"--labels {path} {told} of {training.shown}, which has {len(log):,}")
    values = np.array([labels[it] for it in numbers], np.float64)
    values[values == UNKNOWN] = np.nan
    if not is_whole:
        return replace(training, logs=(log.add({COLUMN: values}),))
    # One label of a whole training stands as one episode of its final policy: it has no time of its own.
    facts = LogFacts(path=path, format=LABELS, unit="episode", evaluation=True)
    return replace(training, evaluation=in_memory(facts, {COLUMN: values}))
