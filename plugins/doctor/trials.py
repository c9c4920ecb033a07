"""Tries every installed simulator and environment for one step, each in a process of its own.

A library that crashes, hangs or prints costs its own line. Several are tried at once, since most of the time goes into
importing libraries.
"""

import os
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from typing import NamedTuple

import harness
from harness.environment import Environment, examples_of
from harness.errors import reason_of
from harness.hookspecs import NOUNS
from harness.registry import Registry, choose, load_registry
from harness.registry.spec import is_met
from harness.text import one_line, print_visible

LIMIT = 60.0
"""Seconds that a trial may take. Importing the largest library takes some five."""
FAILED = 3
"""Exit status of a process whose trial failed in words; its last line of standard error is the reason."""
KINDS = ("simulators", "environments")
"""What is tried."""


class Trial(NamedTuple):
    """One name that was tried."""

    kind: str
    name: str
    problem: str
    """Why it does not work here; empty if it does."""

    @property
    def line(self) -> str:
        """What to say of one that failed."""
        return f"{NOUNS[self.kind]} {self.name} fails here: {self.problem}"


class Example(NamedTuple):
    """A name with parameters that it can be tried with."""

    kind: str
    name: str
    missing: tuple[str, ...] = ()
    """Modules that it takes and that are not installed."""


def examples(registry: Registry) -> Iterator[Example]:
    """All that lacks no library; environments with examples of parameters, of which some may take more libraries."""
    for kind in KINDS:
        for name in registry.names(kind):
            spec = registry.get(kind, name)
            if spec.missing:
                continue
            known = examples_of(spec.load()) if kind == "environments" else {}
            for parameters, modules in known.items():
                missing = tuple(module for module in modules if not is_met(module))
                yield Example(kind, f"{name}:{parameters}", missing)
            if not known:
                yield Example(kind, name)


def half_installed(registry: Registry) -> list[str]:
    """A line for each example of which some modules are there and others are not: somebody meant to install it."""
    lines = []
    for example in examples(registry):
        name = example.name.partition(":")[0]
        spec = registry.get(example.kind, name)
        needed = examples_of(spec.load()).get(example.name.removeprefix(f"{name}:"), ()) if example.missing else ()
        if 0 < len(example.missing) < len(needed):
            what = f"{NOUNS[example.kind]} '{example.name}'"
            lines.append(f"missing {', '.join(example.missing)} for {what}: {spec.remedy}")
    return lines


def try_all(registry: Registry) -> Iterator[Trial]:
    """Try all whose modules are installed, in the order of the names."""
    yield from tried([it for it in examples(registry) if not it.missing])


def tried(ready: Iterable[Example]) -> Iterator[Trial]:
    """Try these, several at once, in this order."""
    with ThreadPoolExecutor(max_workers=max(2, os.cpu_count() or 1)) as pool:
        yield from pool.map(lambda it: Trial(it.kind, it.name, _problem_of(it.kind, it.name)), ready)


def _problem_of(kind: str, name: str) -> str:
    """Why a name does not work here, as a process of its own finds; empty if it does."""
    command = [sys.executable, "-P", "-m", "harness_plugins.doctor.trials", kind, name]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=LIMIT, errors="replace")
    except subprocess.TimeoutExpired:
        return f"it did not take a step within {LIMIT:g} s"
    if done.returncode < 0:
        return f"its process was ended by {signal.Signals(-done.returncode).name}"
    if done.returncode:
        last = done.stderr.strip().splitlines()[-1:]
        return last[0] if last and done.returncode == FAILED else f"its process ended with status {done.returncode}"
    return ""


def take_a_step(kind: str, name: str) -> None:
    """Take one step in an env with a simulator, or in an env of an environment.

    Raises:
        Exception: It fails: whatever a library raises.
    """
    if kind == "simulators":
        with closing(harness.make_env(name)) as batch:
            batch.reset(seed=0)
            batch.step(batch.action_space.sample())
        return
    registry = load_registry()
    environment: Environment = choose(registry, kind, name).build(registry, kind)
    with closing(environment.make()) as env:
        env.reset(seed=0)
        env.step(env.action_space.sample())
        environment.rewards(env), environment.behaviour(env)


def main(kind: str, name: str) -> int:
    """Try one name; the exit status, `FAILED` with the reason on standard error."""
    try:
        take_a_step(kind, name)
    except (Exception, SystemExit) as error:  # whatever a library raises
        print_visible(one_line(reason_of(error)), err=True)  # for who started this process
        return FAILED
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
