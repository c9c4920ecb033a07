"""What decides a result beside its cell: versions, machine, commit, command, the sources of its plugins."""

import importlib.metadata
import os
import platform
import subprocess
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from harness.hookspecs import KINDS
from harness.record.cell import Cell
from harness.registry.registry import Registry
from harness.registry.sources import source_hash
from harness.robot.load import load_robot

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
