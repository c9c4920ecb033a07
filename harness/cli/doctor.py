"""``harness doctor``: what is installed, what is missing, whether this machine renders."""

import subprocess
import sys
from collections.abc import Collection

import typer

from harness.cli.commands import hidden_commands
from harness.hookspecs import NOUNS
from harness.registry.registry import Registry, load_registry

RENDER = """
import numpy, harness
env = harness.make_env()
env.reset(seed=0)
frame = env.render()[0]
assert numpy.ptp(frame) > 0, "the frame is empty"
"""
BACKENDS = {"egl": "libegl1", "osmesa": "libosmesa6"}
"""What MUJOCO_GL may be without a display, and the system package that it takes."""


def doctor(context: typer.Context) -> None:
    """Check versions, plugins, missing libraries, CPU and headless rendering."""
    from harness.experiment.provenance import describe_machine, source_commit, versions_behind

    machine, registry = describe_machine(), load_registry()
    specs = [spec for claims in registry.specs.values() for spec in claims]
    typer.echo(f"python {sys.version.split()[0]} on {machine['system']}")
    typer.echo(f"cpu {machine['cpu']}, {machine['cores']} cores")
    typer.echo("versions " + ", ".join(f"{name} {version}" for name, version in versions_behind(specs).items()))
    commit = source_commit()
    if commit:
        typer.echo(f"commit {commit}")
    for line in _plugin_problems(registry, context.obj) + _missing_libraries(registry) + _rendering(registry):
        typer.echo(line)


def _plugin_problems(registry: Registry, own: Collection[str]) -> list[str]:
    broken = [plugin for plugin in registry.plugins if plugin.status in {"broken", "incompatible"}]
    lines = [
        f"plugin '{plugin.name}' of {plugin.distribution} is {plugin.status}: {plugin.reason}" for plugin in broken
    ]
    lines += registry.conflicts() + hidden_commands(registry, own)
    return lines or [f"plugins {len(registry.plugins)}, all fine"]


def _missing_libraries(registry: Registry) -> list[str]:
    specs = [spec for claims in registry.specs.values() for spec in claims if spec.missing]
    return [f"missing {', '.join(spec.missing)} for {NOUNS[spec.kind]} '{spec.name}': {spec.remedy}" for spec in specs]


def _rendering(registry: Registry) -> list[str]:
    """One line for each way of rendering without a display; each is tried in a process of its own."""
    spec = registry.specs.get(("simulators", "mujoco"))
    if spec is None or spec[0].missing:
        return ["rendering not tried: it takes the simulator mujoco"]
    return [
        f"rendering MUJOCO_GL={backend}: {_try_rendering(backend) or f'fails here: install {package} to have it'}"
        for backend, package in BACKENDS.items()
    ]


def _try_rendering(backend: str) -> str:
    """``works``, or nothing: each backend that is not there fails in its own words, none of which says what to do."""
    import os

    command = [sys.executable, "-c", RENDER]
    tried = subprocess.run(
        command, env={**os.environ, "MUJOCO_GL": backend}, capture_output=True, text=True, check=False
    )
    return "works" if tried.returncode == 0 else ""
