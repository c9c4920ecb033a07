"""What decides a result beside its cell: versions, machine, engine, commit, command, the sources of its plugins."""

import os
import platform
import subprocess
import sys
import tomllib
from collections.abc import Collection, Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from threadpoolctl import threadpool_info

from harness.errors import UsageError
from harness.hookspecs import KINDS
from harness.record.cell import Cell
from harness.registry.choice import Registry
from harness.registry.sources import source_hash
from harness.registry.spec import OURS, Spec, distribution_of, is_installed, version_of
from harness.reward import Sample
from harness.reward.terms import needs_of
from harness.text import command_text

if TYPE_CHECKING:
    from harness.robot import Robot

CORE = (OURS, "gymnasium", "numpy", "pyarrow")
"""Distributions that every result depends on."""
CHECKOUT = Path(__file__).resolve().parents[2]
"""The folder that holds this package. It is the root of the checkout, if the package runs from one."""


def describe_environment(
    cell: Cell, robot: "Robot | None", registry: Registry, kinds: Collection[str] = KINDS
) -> dict[str, Any]:
    """What decides a result beside the cell: versions, machine, engine, commit, command, hashes of sources.

    Args:
        cell: What made the result.
        robot: The cell's, loaded; None where its task is an environment.
        registry: The plugins.
        kinds: Those of the cell's choices that made it.
    """
    specs = specs_of(cell, registry, kinds)
    digests = {kind: digest for kind, spec in specs.items() if (digest := source_hash(spec.load()))}
    engine = {}
    if "simulators" in specs:
        from harness.simulator import family_of  # here, since an environment has none

        engine = {"engine": family_of(specs["simulators"].load())}
    if robot is not None:
        digests["robots"] = robot_digest(cell, robot)
    return {
        "versions": {"python": platform.python_version(), **versions_behind(specs.values())},
        "machine": describe_machine(),
        **engine,
        "commit": source_commit(CHECKOUT),
        "command": command_text(Path(sys.argv[0]).name, *sys.argv[1:]),
        "sources": {**digests, **function_digests(cell, registry)},
        **_what_is_read(cell, robot, specs, registry),
    }


def _what_is_read(
    cell: Cell, robot: "Robot | None", specs: Mapping[str, Spec], registry: Registry
) -> dict[str, dict[str, list[str]]]:
    """What an arm's reward reads beside distances, and its terms; nothing of one that reads distances and has none."""
    if robot is None or "rewards" not in specs:
        return {}
    try:
        found = needs_of(cell.reward.build(registry, "rewards"), robot.dof)
    except UsageError:  # its first step will say why
        return {}
    is_plain = set(found.fields) <= set(Sample._fields) and not found.terms
    return {} if is_plain else {"reward": {"reads": list(found.fields), "terms": list(found.terms)}}


def function_digests(cell: Cell, registry: Registry) -> dict[str, str]:
    """SHA-256 of each file with functions that decides the result of a cell in an environment.

    They are the file of its reward, under ``reward calm``, and those of all measures, under ``measure height``. The
    environment's own rewards and measures are part of the environment.
    """
    if "rewards" in cell.plugins:  # a plugin, which is hashed as such
        return {}
    decisive = [it for it in registry.functions if it.noun == "measure" or it.name == cell.reward.name]
    return {f"{it.noun} {it.name}": it.file.digest for it in decisive}


def robot_digest(cell: Cell, robot: "Robot") -> str:
    """SHA-256 of what decides the cell's result in a robot. Its drives count only if the simulator uses them."""
    return robot.driven_digest if cell.drives_with_servo else robot.digest


def versions_behind(specs: Iterable[Spec]) -> dict[str, str]:
    """Versions of the distributions that results of these plugins depend on, those that are installed.

    These are the core's own, the distribution of each plugin, and those of the modules that it requires: what a plugin
    registers with ``requires=["pinocchio"]`` is recorded with the version of Pinocchio.
    """
    specs = list(specs)
    required = {module for spec in specs for module in spec.modules if is_installed(module)}
    behind = {*map(distribution_of, required), *(spec.distribution for spec in specs)}
    return {name: version for name in dict.fromkeys([*CORE, *sorted(behind)]) if (version := version_of(name))}


def specs_of(cell: Cell, registry: Registry, kinds: Collection[str] = KINDS) -> dict[str, Spec]:
    """The plugins behind the choices of a cell, by kind, without the robot, which is no code."""
    chosen = {kind: name for kind, name in cell.plugins.items() if kind in kinds and kind != "robots"}
    return {kind: registry.get(kind, name) for kind, name in chosen.items()}


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
        "kernel": blas_kernel(),
    }


def blas_kernel() -> str:
    """The kernel by which numpy's OpenBLAS computes, such as ``Haswell``; empty if numpy has another library.

    OpenBLAS takes one by the CPU, or as ``OPENBLAS_CORETYPE`` says. Each adds in another order, so bits differ.
    """
    return next((it["architecture"] for it in threadpool_info() if it["internal_api"] == "openblas"), "")


@lru_cache(maxsize=1)  # what a process runs, it loaded before; a cell would wait for git
def source_commit(checkout: Path) -> str:
    """The commit of a checkout of this project, ``+`` behind it if files differ; as it was when first asked for.

    Args:
        checkout: A folder; empty text if it is no checkout of this project. A repository that only surrounds the
            installation says nothing about it.
    """
    if not _is_checkout(checkout):
        return ""
    try:
        described = subprocess.run(
            ["git", "-C", str(checkout), "describe", "--always", "--abbrev=40", "--dirty=+", "--exclude=*"],
            capture_output=True,
            text=True,
            check=True,
            timeout=10,
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return described.stdout.strip()


def _is_checkout(folder: Path) -> bool:
    """Whether a folder is the root of a repository, and that repository is this project's."""
    if not (folder / ".git").exists():
        return False
    try:
        project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    except (OSError, ValueError, KeyError):
        return False
    return bool(project.get("name") == OURS)
