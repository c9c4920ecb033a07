"""What can be named, as ``harness describe`` lists it."""

from collections.abc import Mapping
from types import MappingProxyType

from harness.cli.commands import KIND, OPTION
from harness.cli.output import complain, say
from harness.hookspecs import KINDS
from harness.registry.choice import Registry

EXPLAINED: Mapping[str, str] = MappingProxyType(
    {
        "simulators": "what moves the arm (--sim)",
        "algorithms": "what learns (--algo)",
        "rewards": "what a step is paid (--reward, --baseline)",
        "metrics": "what is measured of the trained robots (--metric)",
        "robots": "the arms (--robot)",
        "descriptions": "files of arms beside URDF that are read (--robot)",
        "tasks": "what an arm has to do (--task)",
        "environments": "worlds of other libraries, in place of simulator, robot and task (--task)",
        "executors": "where trainings run (--executor)",
        "trackers": "where learning curves are sent (--tracker)",
        "logs": "logs of other programs that report, eta and audit read (--as)",
        "screens": "what looks at rewards before they train (run and choose --screen)",
        "sections": "what commands of plugins add to the report of an experiment",
        "commands": "commands that plugins add: harness NAME",
    }
)
"""What each kind is, and the flag that takes its names."""
READING = (
    "Every name that you can type, and what it is. Some have parameters, as arp:k2=2: harness describe NAME tells.\n"
    "What is not installed says so in brackets."
)


def list_names(registry: Registry, only: str | None = None) -> None:
    """Say every name that can be typed, or those of one kind."""
    say(READING)
    for shown in KINDS if only is None else (only,):
        say(f"\n{shown}: {EXPLAINED[shown]}")
        width = max(16, *map(len, registry.names(shown)), 0) + 2
        for name in registry.names(shown):
            if shown == KIND and OPTION in name:  # an option of ours, which nobody calls as a command
                continue
            spec = registry.get(shown, name)
            note = f" [missing {', '.join(spec.missing)}: {spec.remedy}]" if spec.missing else ""
            short = f"; {spec.short} for short" if spec.short else ""
            say(f"  {name:<{width}}{spec.summary}{short}{note}")
    for line in registry.complaints():
        complain(line)
