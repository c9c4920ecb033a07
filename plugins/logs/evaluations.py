"""``evaluations.npz`` of stable-baselines3's EvalCallback: every episode of every evaluation of a training."""

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from harness import Float
from harness.errors import SchemaError
from harness.files import open_regular, reading
from harness.log import Log, LogFacts, in_memory

from ..zoo_settings import zoo_settings

MOST_BYTES = 2**28
ZIP = b"PK\x03\x04"
MEMBERS = ("timesteps", "results", "ep_lengths", "successes")
"""Arrays of it: (evaluations,), then (evaluations, episodes) each; the last two are not in every file."""


@dataclass(frozen=True)
class Evaluations:
    """Episodes in which a policy that was still learning was evaluated, as EvalCallback keeps them."""

    def recognises(self, path: Path, head: bytes) -> bool:
        """A zip whose first members are those arrays, whatever it is called."""
        if path.suffix != ".npz" or not head.startswith(ZIP):
            return False
        try:
            with zipfile.ZipFile(path) as archive:
                return {"timesteps.npy", "results.npy"} <= {*archive.namelist()}
        except Exception:  # readers of other people's bytes raise anything
            return False

    def read(self, path: Path) -> tuple[Log, ...]:
        """The evaluations of the one training.

        Raises:
            SchemaError: It is damaged, its arrays do not fit one another, or its steps go back.
        """
        with reading(path, "evaluations.npz"):
            arrays = _arrays(path)
            steps, returns = arrays["timesteps"], arrays["results"]
            if steps.ndim != 1 or returns.ndim != 2 or returns.shape[0] != len(steps) or not returns.size:
                raise SchemaError(f"{path}: its results are {returns.shape} of {len(steps)} evaluations")
            for at in np.flatnonzero(np.diff(steps) <= 0.0):
                raise SchemaError(
                    f"{path}: evaluation {at + 2} goes from step {steps[at]:,.0f} to {steps[at + 1]:,.0f}: it holds "
                    "two trainings, or one that went on with reset_num_timesteps=True. Give each call of learn a "
                    "callback and a folder of its own"
                )
            columns = {"time": np.repeat(steps, returns.shape[1]), "reward/recorded": returns.ravel()}
            notes = []
            for member, column in (("ep_lengths", "length"), ("successes", "behaviour/success")):
                if member not in arrays:
                    continue
                if arrays[member].shape == returns.shape:
                    columns[column] = arrays[member].ravel()
                else:
                    notes.append(f"{member} are {arrays[member].shape}, results {returns.shape}: they are left out")
            if not all(np.isfinite(values).all() for values in columns.values()):
                raise SchemaError(f"{path}: a number is missing or not finite")
            if not np.isin(columns.get("behaviour/success", 0.0), (0.0, 1.0)).all():
                raise SchemaError(f"{path}: a success is neither 0 nor 1")
        facts = LogFacts(
            path=path,
            format="evaluations of stable-baselines3's EvalCallback",
            unit="episode",
            **zoo_settings(path)._asdict(),
            evaluation=True,
            bounds={"success": (0.0, 1.0)} if "behaviour/success" in columns else {},
            notes=(f"{len(steps)} evaluations of {returns.shape[1]} episodes each", *notes),
        )
        return (in_memory(facts, columns),)

    def write_example(self, folder: Path) -> Path:
        """Two evaluations of three episodes, under the names and in the shapes of EvalCallback."""
        path = folder / "evaluations.npz"
        returns = [[-3.0, -2.5, -4.0], [-1.0, -1.5, -0.5]]
        lengths, reached = [[10, 9, 10], [7, 8, 6]], [[False, False, False], [True, False, True]]
        with path.open("wb") as file:
            np.savez(file, timesteps=[500, 1000], results=returns, ep_lengths=lengths, successes=reached)
        return path


def _arrays(path: Path) -> Mapping[str, Float]:
    with open_regular(path, MOST_BYTES) as file:
        with zipfile.ZipFile(file) as archive:
            unpacked = sum(member.file_size for member in archive.infolist())
        if unpacked > MOST_BYTES:
            raise SchemaError(f"{path} unpacks to {unpacked:,} bytes; {MOST_BYTES:,} are allowed")
        file.seek(0)
        found: Any = np.load(file, allow_pickle=False)
        arrays = {name: np.asarray(found[name]) for name in MEMBERS if name in found}
    for name, values in arrays.items():
        if values.dtype.kind not in "biuf":
            raise SchemaError(f"{path}: its {name} are no numbers")
        arrays[name] = values.astype(np.float64)
    return arrays
