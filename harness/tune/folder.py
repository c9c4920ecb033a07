"""A tuning's folder.

::

    tuning.toml           what is searched; reads as a tuning file
    study.log             Optuna's journal of the trials
    trials/               an experiment with the cells of all trials
    validation/<cell id>/ evaluation.parquet: the episodes that the policy was judged by; log.txt
    tuned.toml            an experiment with the best settings, once every search has all its trials
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import tomli_w

from harness.errors import UsageError
from harness.files.whole_file import is_partial, write_whole
from harness.record.out_folder import folder_lock, make_folder, refuse_links, storage_errors
from harness.registry.choice import Choice, choose
from harness.registry.registry import Registry
from harness.registry.toml_file import read_toml
from harness.text import shortened
from harness.tune.tuning import Setup

SHOWN = 80
"""The most characters of a value in a message."""
TUNING, TUNED, LOCK = "tuning.toml", "tuned.toml", ".lock"


@contextmanager
def tuning_folder(folder: Path, setup: Setup) -> Iterator[None]:
    """Make the folder, or go on with one of the same search, and keep others out of it.

    Raises:
        UsageError: It cannot be written, holds something else or another search, or is in use. Nothing is written.
    """
    _require_same(folder, setup)
    make_folder(folder)
    refuse_links(folder)
    with storage_errors(folder), folder_lock(folder / LOCK, f"Another search is using '{folder}'"):
        write_whole(folder / TUNING, tomli_w.dumps({**setup.keys, "trials": setup.tuning.trials}))
        yield


def begun_with(folder: Path, registry: Registry) -> list[Choice]:
    """The algorithm of the search that a folder holds; nothing if it holds none.

    Raises:
        UsageError: The search cannot be read.
    """
    if not (folder / TUNING).is_file():
        return []
    return [choose(registry, "algorithms", it) for it in read_toml(folder / TUNING, "tuning file").get("algo", [])]


def _require_same(folder: Path, setup: Setup) -> None:
    """Check that a search is the same as the folder's. It may ask for more trials; any other difference is refused."""
    if folder.exists() and not folder.is_dir():
        raise UsageError(f"--out '{folder}' is a file: name a folder")
    if not (folder / TUNING).is_file():
        if folder.is_dir() and {path.name for path in folder.iterdir() if not is_partial(path)} - {LOCK}:
            raise UsageError(f"--out '{folder}' holds something else than a tuning: name a new or empty folder")
        return
    there = read_toml(folder / TUNING, "tuning file")
    for key, value in setup.keys.items():
        if there.get(key) != value:
            now, then = (shortened(str(one), SHOWN) for one in (value, there.get(key)))
            raise UsageError(f"--out '{folder}' holds another search: {key} was {then}, now {now}: name another folder")
