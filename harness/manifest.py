"""What a cell says of itself: what it was, how it ended, on what machine and with which versions it ran."""

import importlib.metadata
import json
import os
import platform
import subprocess
import sys
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal, TypeAlias

from harness.cell import Cell
from harness.errors import SchemaError
from harness.hookspecs import KINDS
from harness.plugins import Registry
from harness.robot_by_name import load_robot
from harness.source_files import source_hash

FORMAT = 1
FILE = "manifest.json"
Status: TypeAlias = Literal["done", "failed", "skipped", "pending"]

RECORDED = (
    "fd100-harness",
    "dm-control",
    "gymnasium",
    "mujoco",
    "numpy",
    "pybullet",
    "pyarrow",
    "stable-baselines3",
    "torch",
)


@dataclass(frozen=True)
class Manifest:
    """The record of one cell.

    Attributes:
        cell: What was run.
        status: ``done``, ``failed``, ``skipped`` or ``pending``.
        reason: Why it is not done; empty if it is.
        started: UTC, ISO 8601.
        seconds: Wall time of the whole cell.
        training_seconds: Of the training alone, up to the checkpoint it was resumed from included.
        environment: Versions, machine, commit, command, hashes of the sources; see `describe_environment`.
        resumed_from: Environment steps that an earlier process, which was killed, left in a checkpoint; 0 if none did.
        note: After such a process: where the training went on, or why it started over.
    """

    cell: Cell
    status: Status
    reason: str = ""
    started: str = ""
    seconds: float = 0.0
    training_seconds: float = 0.0
    environment: dict[str, Any] = field(default_factory=dict)
    resumed_from: int = 0
    note: str = ""

    def write(self, folder: Path) -> None:
        """Write ``manifest.json`` into `folder`."""
        data = {"format": FORMAT, "id": self.cell.id, **asdict(self), "cell": self.cell.to_json()}
        (folder / FILE).write_text(json.dumps(data, indent=1) + "\n")


def read_manifest(folder: Path) -> Manifest:
    """The manifest in a cell's folder.

    Raises:
        SchemaError: It is damaged or written by a newer version.
    """
    path = folder / FILE
    try:
        data = json.loads(path.read_text())
        version = data.pop("format")
        if version > FORMAT:
            raise SchemaError(f"{path} has format {version}, this version reads up to {FORMAT}")
        del data["id"]
        return Manifest(**{**data, "cell": Cell.from_json(data["cell"])})
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise SchemaError(f"{path} is no readable manifest: {error!r}") from error


def now() -> str:
    """The time in UTC, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def describe_environment(cell: Cell | None, registry: Registry | None, kinds: Iterable[str] = KINDS) -> dict[str, Any]:
    """What decides a result beside the cell: versions, machine, commit, command, hashes of the plugins' sources.

    `kinds` are those of the cell's choices that made the result.
    """
    return {
        "versions": {"python": platform.python_version(), **installed_versions()},
        "machine": describe_machine(),
        "commit": source_commit(),
        "command": " ".join([Path(sys.argv[0]).name, *sys.argv[1:]]),
        "sources": source_hashes(cell, registry, kinds) if cell and registry else {},
    }


def installed_versions() -> dict[str, str]:
    """Versions of the distributions that can change a result, those that are installed."""
    versions = {}
    for name in RECORDED:
        try:
            versions[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
    return versions


def describe_machine() -> dict[str, Any]:
    """Operating system and CPU, with the flags that decide which floating-point kernels run."""
    cpu: Mapping[str, str] = {}
    path = Path("/proc/cpuinfo")
    if path.exists():
        first = path.read_text().split("\n\n")[0]
        cpu = {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in first.split("\n"))}
    return {
        "system": platform.platform(),
        "cpu": cpu.get("model name") or platform.processor() or platform.machine(),
        "cpu_flags": sorted(cpu.get("flags", "").split()),
        "cores": os.cpu_count(),
    }


def source_commit() -> str:
    """The commit of the checkout that this package runs from, ``+`` behind it if files differ; empty if none."""
    folder = Path(__file__).parent
    try:
        described = subprocess.run(
            ["git", "-C", str(folder), "describe", "--always", "--abbrev=40", "--dirty=+", "--exclude=*"],
            capture_output=True,
            text=True,
            check=True,
            timeout=10,
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return described.stdout.strip()


def source_hashes(cell: Cell, registry: Registry, kinds: Iterable[str] = KINDS) -> dict[str, str]:
    """SHA-256 of the files behind each choice, and of the robot: a result whose reward changed since can be told.

    `kinds` are those of the choices that made the result.
    """
    every = {"simulators": cell.simulator, "tasks": cell.task, "algorithms": cell.algorithm, "rewards": cell.reward}
    chosen = {kind: choice for kind, choice in every.items() if kind in kinds}
    hashes = {kind: source_hash(registry.get(kind, choice.name).load()) for kind, choice in chosen.items()}
    robot = load_robot(cell.robot, registry).digest
    return {**{kind: digest for kind, digest in hashes.items() if digest}, "robots": robot}
