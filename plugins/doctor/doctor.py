"""What is installed, what is missing, and what of it works on this machine."""

import base64
import hashlib
import json
import os
import subprocess
import sys
from importlib.metadata import Distribution, PackageNotFoundError, PackagePath, distribution
from pathlib import Path
from typing import TYPE_CHECKING

from harness.cli.commands import hidden_commands
from harness.cli.output import say
from harness.cli.runnable import example_run, usable
from harness.experiment.provenance import CHECKOUT, describe_machine, source_commit, versions_behind
from harness.hookspecs import NOUNS
from harness.registry import OURS, Registry, load_registry
from harness.registry.choice import Plugin
from harness.registry.targets import examined

from .trials import half_installed, try_all

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .trials import Trial

OPTIONAL = "Optional, and not installed. You need a line only if you want to use what it names:"
RENDER = """
import numpy, harness
env = harness.make_env()
env.reset(seed=0)
frame = env.render()[0]
assert numpy.ptp(frame) > 0, "the frame is empty"
"""
BACKENDS = {"": "libegl1", "egl": "libegl1", "osmesa": "libosmesa6"}
"""What MUJOCO_GL may be on Linux without a display, unset included, and the system package that it takes."""
REMEDY = "install it again: pip install --force-reinstall --no-deps, and what you installed it from"
CACHE = "__pycache__"


def show_installation(own: "Sequence[str]") -> int:
    """Print it all, and give the exit status: 1 if a plugin is broken, a file is missing, or something fails.

    Args:
        own: Names of the core's commands.
    """
    machine, registry = describe_machine(), load_registry()
    specs = list(registry.all_specs())
    say(f"python {sys.version.split()[0]} on {machine['system']}")
    say(f"cpu {machine['cpu']}, {machine['cores']} cores")
    say("versions " + ", ".join(f"{name} {version}" for name, version in versions_behind(specs).items()))
    commit = source_commit(CHECKOUT)
    if commit:
        say(f"commit {commit}")
    plugins = examined(registry)
    at_fault = [plugin for plugin in plugins if plugin.is_at_fault]
    notes = registry.conflicts() + hidden_commands(registry, own) + registry.notes
    fine = [] if at_fault or notes else [f"plugins {len(registry.plugins)}, all fine"]
    for line in [*(plugin.complaint for plugin in at_fault), *notes, *fine]:
        say(line)
    files, trials = file_lines(), list(try_all(registry))
    for line in [
        *_group("Broken:", [*files, *(trial.line for trial in trials if trial.problem)]),
        *_group("Plugins:", _told(plugins)),
        *_group("Works here:", [*_tried(trials), *_rendering(registry)]),
        *_group(OPTIONAL, [*_missing_libraries(registry), *half_installed(registry)]),
        "",
        *_what_runs(registry),
    ]:
        say(line)
    return 1 if at_fault or files or any(trial.problem for trial in trials) else 0


def _group(heading: str, lines: "Sequence[str]") -> list[str]:
    """The lines below a heading, with an empty line before it; nothing where there is no line."""
    return ["", heading, *(f"  {line}" for line in lines)] if lines else []


def _told(plugins: "Sequence[Plugin]") -> list[str]:
    """One line for each distribution: what registers something; of others what each registered, and what is off."""
    found: dict[str, list[str]] = {}
    for it in plugins:
        registered = f" ({', '.join(it.registered)})" if it.registered and it.distribution != OURS else ""
        state = registered if it.status == "ok" else f" ({it.status})"
        found.setdefault(f"{it.distribution} {it.version}", []).append(f"{it.name}{state}")
    return [f"{title}: {', '.join(names)}" for title, names in found.items()]


def _tried(trials: "Sequence[Trial]") -> list[str]:
    """One line for all of a kind that took a step."""
    worked: dict[str, list[str]] = {trial.kind: [] for trial in trials}
    for trial in trials:
        worked[trial.kind] += [] if trial.problem else [trial.name]
    return [f"tried {kind}, a step in each: {', '.join(names)}" for kind, names in worked.items() if names]


def _what_runs(registry: Registry) -> list[str]:
    example = example_run(registry)
    if not example:
        return ["you can run nothing yet: install a simulator and an algorithm, as the lines above say"]
    names = [f"installed {kind}: {', '.join(usable(registry, kind))}" for kind in ("simulators", "algorithms")]
    return [*names, f"you can run: {example}"]


def _missing_libraries(registry: Registry) -> list[str]:
    """One line for all of a kind that lack the same."""
    names: dict[tuple[str, str, str], list[str]] = {}
    for spec in registry.all_specs():
        if spec.missing:
            names.setdefault((spec.kind, ", ".join(spec.missing), spec.remedy), []).append(spec.name)
    return [
        f"missing {libraries} for {_named(kind, found)}: {remedy}" for (kind, libraries, remedy), found in names.items()
    ]


def _named(kind: str, names: list[str]) -> str:
    return f"{NOUNS[kind]} '{names[0]}'" if len(names) == 1 else f"{NOUNS[kind]}s {', '.join(sorted(names))}"


def _rendering(registry: Registry) -> list[str]:
    """One line for each way of rendering; each is tried in a process of its own."""
    spec = registry.specs.get(("simulators", "mujoco"))
    if spec is None or spec[0].missing:
        return ["rendering not tried: it needs the simulator mujoco"]
    if sys.platform != "linux":  # the other ways are Linux's alone, and there is nothing to install
        return [f"rendering {_try_rendering('') or 'fails here'}"]
    return [
        f"rendering {f'MUJOCO_GL={backend}' if backend else 'without MUJOCO_GL'}: "
        f"{_try_rendering(backend) or f'fails here: install {package} to have it'}"
        for backend, package in BACKENDS.items()
    ]


def _try_rendering(backend: str) -> str:
    """``works``, or nothing: a library that is not there fails in its own words, which do not say what to do."""
    command = [sys.executable, "-c", RENDER]
    # MuJoCo takes an empty MUJOCO_GL for one that is not set.
    tried = subprocess.run(
        command, env={**os.environ, "MUJOCO_GL": backend}, capture_output=True, text=True, check=False
    )
    return "works" if tried.returncode == 0 else ""


def file_lines(name: str = OURS) -> list[str]:
    """One line for each file of a distribution that is missing or was changed since it was installed.

    An editable installation has no files of its own: it uses the checkout, and so does one that is not installed. Nor
    does the metadata that a build leaves in a checkout list installed files: it has no RECORD.
    """
    try:
        found = distribution(name)
    except PackageNotFoundError:
        return []
    if found.read_text("RECORD") is None or _is_editable(found):
        return []
    problems = [(str(path), _problem(path)) for path in found.files or () if CACHE not in path.parts]
    return [f"file {path} {problem}: {REMEDY}" for path, problem in problems if problem]


def _is_editable(found: Distribution) -> bool:
    told = json.loads(found.read_text("direct_url.json") or "{}")
    return bool(told.get("dir_info", {}).get("editable"))


def _problem(path: PackagePath) -> str:
    """What is wrong with a file that RECORD names; empty if nothing is."""
    place = Path(path.locate())
    if not place.is_file():
        return "is missing"
    if path.hash is None:  # RECORD itself
        return ""
    digest = hashlib.new(path.hash.mode, place.read_bytes()).digest()
    told = base64.urlsafe_b64encode(digest).decode().rstrip("=")
    return "" if told == path.hash.value else "is not what was installed"
