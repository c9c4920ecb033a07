"""Pages of the site that are made from the code: commands, the experiment file, plugins with their fields, the API.

A Sphinx extension. It writes them into ``docs/generated`` before Sphinx looks for pages; nothing there is kept. The
committed records, the robots' read-mes and the files at the repository's top become pages too; links lead there.
"""

import inspect
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer
from sphinx.application import Sphinx

from harness.cli.app import PANELS, build_app
from harness.experiment.plan import Experiment
from harness.hookspecs import NOUNS
from harness.registry.parameters import parameters_of
from harness.registry.registry import Registry, load_registry

ROOT = Path(__file__).parents[2]
FOLDER = "generated"
TOP = ("CHANGELOG", "CONTRIBUTING", "SECURITY")
"""Pages that stand at the repository's top."""
LINK = re.compile(r"\]\((<?)(?![a-z]+:|#|/)([^)]+)\)")
"""One that leads to a file."""
OUTSIDE = re.compile(r"\[([^]]*)\]\((?:\.\./)+([\w./-]+)(#[\w-]+)?\)")
RECORD = re.compile(r"results/reference/([\w/-]+)/summary\.md")
"""Records may stand in a folder of several; pages of them stand beside one another."""
ROBOT = re.compile(r"robots/(\w+)/README\.md")
FLAT = (
    "harness", "harness.simulator", "harness.task", "harness.reward", "harness.algorithm", "harness.metric",
    "harness.executor", "harness.tracker", "harness.progress", "harness.reach", "harness.robot", "harness.errors",
    "harness.results", "harness.hookspecs", "harness.pytest_plugin", "harness_plugins.sb3",
)  # fmt: skip
"""Modules that people import."""
KINDS = tuple(kind for kind in NOUNS if kind not in {"robots", "commands"})
MARKUP = re.compile(r"\[/?(?:bold|dim|italic|cyan|green|yellow|red|/)?\]")


def setup(app: Sphinx) -> dict[str, Any]:
    """Have the pages written before Sphinx reads any."""
    app.connect("config-inited", lambda app, _: write_pages(Path(app.srcdir) / FOLDER))
    app.connect("source-read", _lead_to_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def write_pages(folder: Path) -> None:
    """Write every generated page; one that is as before is left alone, so that Sphinx does not read it again."""
    for name in ("records", "robots"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    registry = load_registry()
    pages = {
        "commands.md": commands_page(),
        "experiment-file.md": experiment_page(),
        "api.md": api_page(),
        **{f"{kind}.md": kind_page(kind, registry) for kind in KINDS},
        **{f"{name}.md": _copied(ROOT / f"{name}.md", folder / f"{name}.md") for name in TOP},
        **{
            f"records/{_record_page(path.relative_to(ROOT).as_posix())}": _copied(path, folder / "records" / path.name)
            for path in sorted(ROOT.glob("results/reference/**/summary.md"))
        },
        **{
            f"robots/{path.parent.name}.md": _copied(path, folder / "robots" / path.name)
            for path in sorted(ROOT.glob("robots/*/README.md"))
        },
    }
    for name, text in pages.items():
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def _record_page(path: str) -> str:
    """The page of the records whose ``summary.md`` stands at `path`, from the repository's top."""
    return RECORD.sub(lambda found: f"{found[1].replace('/', '-')}.md", path)


def _copied(path: Path, page: Path) -> str:
    """The text of a file at `path`, to stand at `page`: its links are told from there."""
    away = os.path.relpath(path.parent, page.parent).replace(os.sep, "/")
    return LINK.sub(rf"](\g<1>{away}/\g<2>)", path.read_text(encoding="utf-8"))


def _lead_to_pages(app: Sphinx, page: str, content: list[str]) -> None:
    """Links out of ``docs`` lead to the page of the site where there is one; folders of code are no links."""
    up = "../" * page.count("/")

    def led(found: re.Match[str]) -> str:
        text, path, anchor = found[1], found[2], found[3] or ""
        if RECORD.fullmatch(path):
            return f"[{text}]({up}{FOLDER}/records/{_record_page(path)}{anchor})"
        if robot := ROBOT.fullmatch(path):
            return f"[{text}]({up}{FOLDER}/robots/{robot[1]}.md{anchor})"
        if path.removesuffix(".md") in TOP:
            return f"[{text}]({up}{FOLDER}/{path}{anchor})"
        return text if (ROOT / path).is_dir() else found[0]

    content[0] = OUTSIDE.sub(led, content[0])


def commands_page() -> str:
    """Every command with its help, arguments and options."""
    group = typer.main.get_command(build_app())
    parts = ["# Commands", "Every command with all of its options."]
    for panel, names in PANELS.items():
        parts.append(f"## {panel}")
        for name in names:
            parts.extend(_command(name, group.commands[name]))  # type: ignore[attr-defined]
    return _joined(parts)


def _command(name: str, command: Any) -> Iterator[str]:
    context = typer.Context(command, info_name=f"harness {name}")
    yield f"### harness {name}"
    yield f"```text\n{command.get_usage(context)}\n```"
    yield inspect.cleandoc(command.help or "")
    shown = [it for it in command.get_params(context) if not getattr(it, "hidden", False)]
    rows = [(_declared(it, context), _cell(getattr(it, "help", None) or "")) for it in shown]
    yield _table(("argument or option", "what it is"), rows)


def _declared(parameter: Any, context: Any) -> str:
    if parameter.param_type_name == "argument":
        return f"`{str(parameter.name).upper()}`"
    names = ", ".join(f"`{name}`" for name in (*parameter.opts, *parameter.secondary_opts))
    default = parameter.default
    told = default not in (None, False, (), []) and not callable(default)
    return f"{names} (default `{default}`)" if told else names


def experiment_page() -> str:
    """Every key of an experiment file."""
    rows = [
        (f"`{it.name}`", _cell(it.type), f"`{it.default}`", _cell(it.description)) for it in parameters_of(Experiment)
    ]
    return _joined(
        [
            "# The experiment file",
            "A TOML file that `harness run FILE` takes. Each key is also a flag of `harness run`. A flag overrides it.",
            _table(("key", "type", "default", "what it is"), rows),
        ]
    )


def kind_page(kind: str, registry: Registry) -> str:
    """Every built-in plugin of one kind, with its parameters."""
    parts = [f"# Built-in {kind}", f"Every {NOUNS[kind]} of this version with its parameters."]
    for name in registry.names(kind):
        spec = registry.get(kind, name)
        parts += [f"## {name}", f"{spec.summary}."]
        try:
            target = spec.load()
        except Exception as error:  # its library is not installed where the site is built
            parts.append(f"*Its parameters are missing here: {_cell(str(error))}*")
            continue
        parts.append(_as_markdown(target))
        rows = [
            (f"`{it.name}`", _cell(it.type), f"`{it.default}`", _cell(it.description)) for it in parameters_of(target)
        ]
        parts.append(_table(("parameter", "type", "default", "what it is"), rows) if rows else "It has no parameters.")
    return _joined(parts)


def api_page() -> str:
    """The public modules, from their docstrings."""
    parts = [
        "# Python",
        "What you import, from the docstrings. Arrays name their shape, quantities their unit. NOTE, ARP and UNITY are "
        "the three [sources](../sources.md) of this project: NOTE eq. 21 is equation 21 of [the note](../note.md).",
    ]
    for module in FLAT:
        parts += [f"## {module}", f"```{{eval-rst}}\n.. automodule:: {module}\n   :members:\n   :undoc-members:\n```"]
    return _joined(parts)


def _as_markdown(target: Any) -> str:
    return inspect.cleandoc(target.__doc__ or "").replace("``", "`")


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "| " + " | ".join("---" for _ in head) + " |"]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def _cell(text: str) -> str:
    return " ".join(MARKUP.sub("", text).replace("|", "\\|").split())


def _joined(parts: list[str]) -> str:
    return "\n\n".join(part for part in parts if part) + "\n"
