"""The help of the commands: what people type first, and on demand the rest, in groups."""

import inspect
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import fields
from itertools import takewhile
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer
from typer.core import TyperCommand, TyperGroup
from typer.exceptions import TyperException

from harness.cli.output import say
from harness.errors import UsageError
from harness.registry.spec import did_you_mean
from harness.text import visible

if TYPE_CHECKING:
    from typer.core import TyperArgument, TyperOption


DEFAULT = re.compile(r"  \[default: \((.+)\)\]")
"""A default that is told in words, as typer writes it."""
CommandFunction = TypeVar("CommandFunction", bound=Callable[..., Any])
ALL, HELP_ALL = "--all", "--help-all"
PLAIN = MappingProxyType({"max_content_width": 100})
"""Settings of every command: a wider terminal does not make longer lines."""
FIRST = ("demo", "run", "report", "choose", "watch", "audit", "eta", "score", "describe", "doctor")
"""The commands that the short help shows, in this order."""
TYPED = ("sim", "algo", "reward", "baseline", "task", "plugin", "seeds", "until", "steps", "out", "jobs", "dry_run")
"""The parameters of ``harness run`` and ``harness choose`` that people type: their short help shows these."""
GROUPS: Mapping[str, Sequence[str]] = MappingProxyType(
    {
        "How the answer is found": ("looks", "margin", "measure", "metrics", "curve", "screen", "fail_on"),
        "How policies are evaluated": (
            *("evaluation_episodes", "evaluate_every", "deterministic", "evaluation_horizon"),
        ),
        "What is trained": ("robot", "only", "limit", "budget", "retry_failed", "fail_fast", "changed", "wait"),
        "Where they run, and within which limits": (
            *("executor", "fresh", "checkpoint_every", "stall_after", "cell_time", "cell_memory"),
        ),
        "What is shown": ("watch", "tracker", "quiet", "as_json"),
    }
)
"""All other parameters of these two, by the heading that they stand under with ``--help-all``."""
SEEDED = "3 trains the seeds 0, 1 and 2; --seeds 3, trains seed 3 alone."
"""What a number behind ``--seeds`` means, and how one seed is named."""
OTHER_FLAGS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "--jobs": ("--workers", "--num-workers", "--n-jobs", "--parallel", "--processes", "--threads", "-j"),
        "--algo": ("--algorithm", "--agent", "--model", "--policy"),
        "--sim": ("--simulator", "--engine", "--physics", "--backend"),
        "--steps": ("--timesteps", "--total-timesteps", "--n-timesteps", "--num-steps", "--max-steps", "-n"),
        "--task": ("--env", "--env-id", "--environment", "--gym-id"),
        "--seeds": ("--seed", "--n-seeds", "--num-seeds", "--trials", "--repeats"),
        "--out": ("--output", "--output-dir", "--out-dir", "--log-dir", "--logdir", "--save-dir", "--folder", "-o"),
        "--reward": ("--rewards", "--reward-function", "--candidates"),
        "--evaluation-episodes": ("--eval-episodes", "--n-eval-episodes", "--episodes"),
        "--evaluate-every": ("--eval-freq", "--eval-every"),
        "--tracker": ("--track", "--wandb", "--tensorboard", "--logger"),
        "--plugin": ("--plugins", "--file"),
        "--dry-run": ("--dryrun", "--plan", "--estimate"),
        "--budget": ("--time", "--time-limit", "--timeout"),
    }
)
"""Flags of ours, each with what other tools call the same."""
OTHER_COMMANDS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "run": ("train", "experiment", "benchmark", "start", "learn"),
        "report": ("results", "plot", "evaluate", "summary"),
        "watch": ("monitor", "tail", "view"),
        "status": ("progress", "ps"),
        "describe": ("info", "explain", "list-envs", "envs", "ls", "show"),
        "demo": ("example", "quickstart"),
    }
)
"""Commands of ours, each with what other tools call the same."""
GONE: Mapping[str, str] = MappingProxyType(
    {
        "bench": "pytest-benchmark times a package, see docs/how-to/timings.md",
        "compare": "type harness report BEFORE and harness report AFTER",
        "list": "type harness describe, without a name or with a kind such as rewards",
        "plugins": "type harness doctor",
        "tune": "a program with Optuna does it, see docs/how-to/tune.md",
    }
)
"""Commands of earlier versions, each with what takes its place."""


class Command(TyperCommand):
    """A command whose help keeps the lines of its examples."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Called with what was typed: a shell makes several words of a pattern without quotes."""
        if any(word == "--plugin" and after.endswith(".py") for word, after in zip(args, args[2:], strict=False)):
            raise UsageError("--plugin takes one file: repeat it, or quote a pattern of files, as in 'rewards/*.py'")
        return super().parse_args(ctx, args)

    def get_help(self, ctx: Any) -> str:
        """Called for the whole text, which plugins wrote parts of."""
        return visible(super().get_help(ctx), keep="\n")

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Called when the help is written."""
        parameters = self.get_params(ctx)
        arguments = [it for it in parameters if it.param_type_name == "argument"]
        _write_section(ctx, formatter, "Arguments", arguments)
        _write_section(ctx, formatter, "Options", [it for it in parameters if it not in arguments])

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Called when the help is written."""
        _write_lines(formatter, self.epilog)


class LongCommand(Command):
    """A command with so many options that its help shows those that people type, and all with ``--help-all``."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Called when the help is written."""
        shown = {it.name: it for it in self.get_params(ctx)}
        grouped = {name for names in (TYPED, *GROUPS.values()) for name in names}
        arguments = [it for it in shown.values() if it.param_type_name == "argument"]
        options = [it for it in shown.values() if it not in arguments]
        rest = [it for it in options if it.name not in grouped]  # --help and --help-all
        typed = [shown[name] for name in TYPED if name in shown]
        _write_section(ctx, formatter, "Arguments", arguments)
        _write_section(ctx, formatter, "Options", [*typed, *rest])
        for heading, names in GROUPS.items() if ctx.meta.get(HELP_ALL) else ():
            _write_section(ctx, formatter, heading, [shown[name] for name in names if name in shown])


class Commands(TyperGroup):
    """All commands: the help shows `FIRST`, and every one with ``--all``."""

    def get_help(self, ctx: Any) -> str:
        """Called for the whole text, which plugins wrote parts of."""
        return visible(super().get_help(ctx), keep="\n")

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Called with what was typed: ``--help --all`` is ``--all``, which an earlier ``--help`` would hide."""
        asked = list(takewhile(lambda word: word.startswith("-"), args))
        return super().parse_args(ctx, [ALL] if ALL in asked else args)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Called with what was typed behind ``harness``: what other tools call a command is answered with ours."""
        try:
            return super().resolve_command(ctx, args)
        except TyperException as error:
            if args[0] in GONE:
                error.message = f"The command '{args[0]}' is gone: {GONE[args[0]]}."
            elif meant := our_word(args[0], OTHER_COMMANDS, self.commands):
                error.message = f"No such command '{visible(args[0])}'. Did you mean '{meant}'?"
            raise

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Called when the help is written: the commands first."""
        commands = self.commands
        if ctx.meta.get(ALL):
            headings = dict.fromkeys(getattr(it, "rich_help_panel", None) for it in commands.values())
            for heading in headings:
                names = [name for name, it in commands.items() if getattr(it, "rich_help_panel", None) == heading]
                _write_rows(
                    formatter, heading or "Commands", [(name, _first_sentence(commands[name])) for name in names]
                )
        else:
            named = [(name, _first_sentence(commands[name])) for name in FIRST if name in commands]
            _write_rows(formatter, "Commands", named)
        wanted = None if ctx.meta.get(ALL) else ("version", "whole", "help")
        options = [it for it in self.get_params(ctx) if wanted is None or it.name in wanted]
        _write_section(ctx, formatter, "Options", options)

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Called when the help is written."""
        _write_lines(formatter, self.epilog)


def our_word(given: str, others: Mapping[str, Sequence[str]], known: Collection[str]) -> str:
    """What is called so here, of a word of other tools; empty where this is none, or is not `known` here."""
    return next((ours for ours, words in others.items() if given in words and ours in known), "")


def meant_flag(given: str, command: Any) -> str:
    """A question to add to a message on a flag that a command lacks; empty without a near match."""
    known = [flag for it in command.params for flag in (*it.opts, *it.secondary_opts) if flag.startswith("--")]
    if any(given in words for words in OTHER_FLAGS.values()):
        ours = our_word(given, OTHER_FLAGS, known)
        count = f" --seeds {SEEDED}" if (given, ours) == ("--seed", "--seeds") else ""
        return f" Did you mean '{ours}'?{count}" if ours else ""
    return did_you_mean(given, known)


def _show_whole(context: typer.Context, parameter: Any, wanted: bool) -> None:
    """Show the help with everything in it, and end."""
    if wanted:
        context.meta[parameter.opts[0]] = True
        say(context.get_help())
        raise typer.Exit


def whole_help(name: str, text: str) -> Any:
    """The option of this name, which shows all of the help."""
    return typer.Option(name, help=text, callback=_show_whole, is_eager=True, expose_value=False)


def takes(
    flags: type, names: Collection[str] | None = None, **others: Any
) -> Callable[[CommandFunction], CommandFunction]:
    """Give a command, a function of ``**given``, the flags that are the fields of a dataclass.

    Args:
        flags: The dataclass.
        names: The fields that it takes; all by default.
        others: Flags that it has besides, or in place of fields; all may be left out.
    """
    taken = {it.name: (it.type, it.default) for it in fields(flags) if names is None or it.name in names}
    taken |= {name: (kind, None) for name, kind in others.items()}
    parameters = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind)
        for name, (kind, default) in taken.items()
    ]

    def give(command: CommandFunction) -> CommandFunction:
        vars(command)["__signature__"] = inspect.Signature(parameters)
        return command

    return give


HelpAll = Annotated[bool, whole_help(HELP_ALL, "Show every option, in groups.")]
All = Annotated[bool, whole_help(ALL, "Show every command and option.")]


def _write_section(ctx: Any, formatter: Any, heading: str, parameters: Sequence[Any]) -> None:
    _write_rows(formatter, heading, list(_records(ctx, parameters)))


def _records(ctx: Any, parameters: "Sequence[TyperOption | TyperArgument]") -> Iterator[tuple[str, str]]:
    for parameter in parameters:
        record = parameter.get_help_record(ctx)
        if record is not None:
            name, text = record
            yield name.replace(" <path>", ""), DEFAULT.sub(r" [default: \1]", text)


def _write_rows(formatter: Any, heading: str, rows: Sequence[tuple[str, str]]) -> None:
    if rows:
        with formatter.section(heading):
            formatter.write_dl(rows)


def _write_lines(formatter: Any, text: str | None) -> None:
    """The text behind an empty line, each of its lines as it is: an example that is broken cannot be copied."""
    if text:
        formatter.write(f"\n{text}\n")


def _first_sentence(command: Any) -> str:
    """What the help of a command begins with."""
    paragraph = " ".join(inspect.cleandoc(command.help or "").partition("\n\n")[0].split())
    sentence, stop, _ = paragraph.partition(". ")
    return sentence + stop.strip()


FIRST_STEPS = ("harness demo", "harness run --sim mujoco --algo sac")

EXAMPLES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "demo": ("harness demo", "harness demo --out my-first"),
        "run": (
            "harness run --sim mujoco --algo sac",
            "harness run --sim kinematic --algo ik --reward arp,scaled:factor=3 --seeds 3",
            "harness run --sim mujoco --algo sac --reward dense --until decided",
            "harness run experiment.toml --seeds 20 --out my-results --dry-run",
        ),
        "choose": (
            "harness choose --reward arp,dense,relative --sim mujoco --algo sac",
            "harness choose --plugin 'candidates/*.py' --task gymnasium:id=Pendulum-v1 --algo sac",
        ),
        "report": (
            "harness report my-results",
            "harness report my-results --details",
            "harness report my-results more-results",
            "harness report my-results --html page.html --summary records",
        ),
        "status": ("harness status my-results",),
        "eta": ("harness eta --baseline 'base/*.csv' --proposed 'k2/*.csv'", "harness eta recorded --plot page.html"),
        "score": ("harness score my-results --reward arp:k2=2 --all", "harness score runs.csv --reward sparse"),
        "verify": ("harness verify my-results", "harness verify my-results --repair"),
        "merge": ("harness merge from-one from-another --out all",),
        "describe": ("harness describe", "harness describe rewards", "harness describe sac:gamma=0.9"),
    }
)


def epilog_of(examples: tuple[str, ...], title: str = "Examples:") -> str:
    """The lines at the end of a help."""
    return "\n".join([title, *(f"  {example}" for example in examples)])
