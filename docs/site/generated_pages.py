"""Pages of the site that are made from the code: commands, the experiment file, plugins with their fields, the API.

A Sphinx extension. It writes them into ``docs/generated`` before Sphinx looks for pages; nothing there is kept. The
committed records, the robots' read-mes and the files at the repository's top become pages too; links lead there.

``docs/index.md`` decides what stands in the sidebar: each item of its list begins with a caption, and the links behind
it are its pages. So the index reads the same on a forge. Links lead to all other pages; records are not searched.
"""

import importlib
import inspect
import os
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import typer
from sphinx.application import Sphinx

from harness.cli.app import PANELS, build_app
from harness.cli.commands import OPTION, PANEL
from harness.experiment.plan import Experiment
from harness.hookspecs import NOUNS
from harness.registry.choice import Registry
from harness.registry.members import parameters_of
from harness.registry.registry import load_registry
from harness_plugins.kit.kits import KITS

ROOT = Path(__file__).parents[2]
FOLDER = "generated"
INDEX = "index"
TOP = ("CHANGELOG", "CONTRIBUTING", "SECURITY")
"""Pages that stand at the repository's top."""
LINK = re.compile(r"\]\((<?)(?![a-z]+:|#|/)([^)]+)\)")
"""One that leads to a file."""
OUTSIDE = re.compile(r"\[([^]]*)\]\((?:\.\./)+([\w./-]+)(#[\w-]+)?\)")
RECORD = re.compile(r"results/reference/([\w/-]+)/summary\.md")
"""Records may stand in a folder of several; pages of them stand beside one another."""
ROBOT = re.compile(r"robots/(\w+)/README\.md")
PUBLIC = (
    "harness", "harness.simulator", "harness.task", "harness.environment", "harness.reward", "harness.algorithm",
    "harness.policy", "harness.executor", "harness.log", "harness.files", "harness.robot", "harness.results",
    "harness.errors", "harness_plugins.kit", "harness_plugins.sb3",
)  # fmt: skip
"""The modules whose names, those of ``__all__``, are for everybody: all that a plugin may import."""
MODULES = (*PUBLIC, "harness.log.log", "harness.hookspecs", "harness_plugins.kit.pytest_plugin")
"""Each has a page; the last ones tell the columns of a log, the hooks, and the fixtures for tests."""
SECTION = re.compile(r"^\* \*\*(.+?):\*\* (.*?)(?=^\S|^$|\Z)", re.MULTILINE | re.DOTALL)
"""An item of a list: its caption, and the links behind it."""
ENTRY = re.compile(r"\]\(([\w./-]+\.md)\)")
GENERATED = {"Look up": ("commands", "experiment-file", "built-in", "checks", "api")}
"""By caption of the index: pages that stand there and are on no forge, since they are made from the code."""
KINDS = tuple(kind for kind in NOUNS if kind not in {"robots", "commands"})
MARKUP = re.compile(r"\[/?(?:bold|dim|italic|cyan|green|yellow|red|/)?\]")


def setup(app: Sphinx) -> dict[str, Any]:
    """Have the pages written before Sphinx reads any."""
    app.connect("config-inited", lambda app, _: write_pages(Path(app.srcdir) / FOLDER))
    app.connect("source-read", _lead_to_pages)
    app.add_config_value("sidebar_pages", sorted(_listed_pages()), "env")  # another sidebar: all pages are read again
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def write_pages(folder: Path) -> None:
    """Write every generated page; one that is as before is left alone, so that Sphinx does not read it again."""
    for name in ("api", "records", "robots"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    registry = load_registry()
    pages = {
        "commands.md": commands_page(registry),
        "experiment-file.md": experiment_page(),
        "api.md": api_page(),
        **{f"api/{module}.md": module_page(module) for module in MODULES},
        "built-in.md": built_in_page(registry),
        "checks.md": checks_page(),
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

    text = OUTSIDE.sub(led, content[0])
    if page == INDEX:
        content[0] = text + _toctrees(content[0])
    elif page not in _listed_pages():
        searched = "nosearch: true\n" if page.startswith(f"{FOLDER}/records/") else ""
        content[0] = f"---\norphan: true\n{searched}---\n\n{text}"
    else:
        content[0] = text


def sidebar(index: str) -> dict[str, list[str]]:
    """By caption of the index, whose text is `index`: the pages that it lists, by their names for Sphinx."""
    pages = {title: [_page_name(path) for path in ENTRY.findall(text)] for title, text in SECTION.findall(index)}
    for title, names in GENERATED.items():
        pages.setdefault(title, []).extend(f"{FOLDER}/{name}" for name in names)
    return {title: names for title, names in pages.items() if names}


def _page_name(path: str) -> str:
    """What Sphinx calls the page that `path` leads to, from the index."""
    name = path.removesuffix(".md")
    return f"{FOLDER}/{Path(name).name}" if Path(name).name in TOP else name


def _listed_pages() -> set[str]:
    text = (ROOT / "docs" / f"{INDEX}.md").read_text(encoding="utf-8")
    return {name for names in sidebar(text).values() for name in names}


def _toctrees(index: str) -> str:
    trees = (
        "\n".join(["```{toctree}", ":hidden:", f":caption: {title}", "", *names, "```"])
        for title, names in sidebar(index).items()
    )
    return "\n\n" + "\n\n".join(trees) + "\n"


def commands_page(registry: Registry) -> str:
    """Every command with its help, arguments and options, those of our plugins too."""
    app = build_app()
    brought = [name for name in registry.names("commands") if OPTION not in name]
    for name in brought:
        app.command(name)(registry.get("commands", name).load())
    group = typer.main.get_command(app)
    parts = ["# Commands", "Every command with all of its options."]
    for panel, names in {**PANELS, PANEL: brought}.items():
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


def built_in_page(registry: Registry) -> str:
    """Every built-in plugin of every kind, with its parameters."""
    parts = [
        "# Built-in plugins",
        "Every plugin of this version with its parameters, as `harness describe NAME` tells.",
    ]
    for kind in KINDS:
        parts.append(f"## {NOUNS[kind].capitalize()}s")
        for name in registry.names(kind):
            parts += _plugin(kind, name, registry)
    return _joined(parts)


def _plugin(kind: str, name: str, registry: Registry) -> Iterator[str]:
    spec = registry.get(kind, name)
    yield f"### {NOUNS[kind].capitalize()} {name}"
    yield f"{spec.summary}."
    try:
        target = spec.load()
    except Exception as error:  # its library is not installed where the site is built
        yield f"*Its parameters are missing here: {_cell(str(error))}*"
        return
    yield _as_markdown(target)
    rows = [(f"`{it.name}`", _cell(it.type), f"`{it.default}`", _cell(it.description)) for it in parameters_of(target)]
    yield _table(("parameter", "type", "default", "what it is"), rows) if rows else "It has no parameters."


def checks_page() -> str:
    """Every check of the contract kit, from the first paragraph of its docstring."""
    parts = ["# Checks of the contract kit", "[The contract kit](../contracts.md) says how to run them."]
    for kind, kit in KITS.items():
        rows = [(f"`{it.name}`", it.level, _as_markdown_text(it.fact)) for it in kit.checks]
        parts += [f"## {NOUNS[kind].capitalize()}s", _table(("check", "level", "what holds"), rows)]
    return _joined(parts)


def _as_markdown_text(text: str) -> str:
    return text.replace("``", "`").replace("|", "or")


def api_page() -> str:
    """The list of the public modules."""
    rows = [(f"[`{module}`](api/{module}.md)", _first_line(importlib.import_module(module))) for module in MODULES]
    return _joined(
        [
            "# Python",
            "What you import, from the docstrings. Arrays name their shape, quantities their unit. NOTE, ARP and UNITY "
            "are the three [sources](../sources.md). NOTE eq. 21 is equation 21 of [the note](../note.md).",
            _table(("module", "what it has"), rows),
            "## Public names",
            "[What stays](../plugins.md#what-stays) holds for these.",
            *(f"```python\n{text}\n```" for text in map("\n".join, map(signatures, PUBLIC))),
        ]
    )


def signatures(module: str) -> list[str]:
    """A line for each public name of a module, with its arguments and their defaults; of an interface, its members."""
    loaded = importlib.import_module(module)
    return [line for name in loaded.__all__ for line in _signatures(f"{module}.{name}", getattr(loaded, name))]


def _signatures(name: str, thing: Any) -> Iterator[str]:
    is_error = inspect.isclass(thing) and issubclass(thing, BaseException)
    if getattr(thing, "_is_protocol", False):
        yield name
        members = [it for it in dir(thing) if not it.startswith("_") or it == "__call__"]
        for member in members:
            yield from _signatures(f"{name}.{member}", inspect.getattr_static(thing, member))
    elif is_error or thing is Any or not (inspect.isclass(thing) or inspect.isroutine(thing)):
        yield name
    else:
        plain = inspect.signature(thing).replace(return_annotation=inspect.Signature.empty)
        yield f"{name}{plain.replace(parameters=list(map(_bare, plain.parameters.values())))}"


class _Dots:
    """A default that is no plain value."""

    def __repr__(self) -> str:
        return "..."


def _bare(parameter: inspect.Parameter) -> inspect.Parameter:
    """An argument without its type."""
    is_plain = isinstance(parameter.default, bool | int | float | str | None)
    default = parameter.default if is_plain or parameter.default is parameter.empty else _Dots()
    return parameter.replace(annotation=parameter.empty, default=default)


def module_page(module: str) -> str:
    """One public module: what its ``__all__`` names; where it has none, all public members that it defines itself.

    Each name is looked up by itself, since a module may import it only when it is first used.
    """
    loaded = importlib.import_module(module)
    parts = [f"# {module}", f"```{{eval-rst}}\n.. currentmodule:: {module}\n```"]
    names = getattr(loaded, "__all__", None)
    if names is None:
        return _joined([parts[0], _directive("automodule", module)])
    return _joined([*parts, _as_markdown(loaded), *(_member(loaded, name) for name in names)])


def _member(module: ModuleType, name: str) -> str:
    """What a page says of a public name; a class that an earlier module has too is explained there."""
    full, thing = f"{module.__name__}.{name}", getattr(module, name)
    if name.startswith("_") or getattr(thing, "__origin__", None) is np.ndarray:
        return f"`{full}` is `{thing!r}`."
    earlier = MODULES[: MODULES.index(module.__name__)]
    for other in earlier if inspect.isclass(thing) else ():
        if name in getattr(importlib.import_module(other), "__all__", ()):
            return f"`{full}` is explained in [{other}]({other}.md)."
    return _directive(_directive_of(thing), full)


def _directive(kind: str, name: str) -> str:
    members = "" if kind in {"autofunction", "autodata"} else "\n   :members:\n   :undoc-members:"
    return f"```{{eval-rst}}\n.. {kind}:: {name}{members}\n```"


def _directive_of(thing: Any) -> str:
    if inspect.isclass(thing):
        return "autoexception" if issubclass(thing, BaseException) else "autoclass"
    return "autofunction" if inspect.isroutine(thing) else "autodata"


def _first_line(thing: Any) -> str:
    return _cell(_as_markdown(thing).split("\n\n")[0])


def _as_markdown(target: Any) -> str:
    return inspect.cleandoc(target.__doc__ or "").replace("``", "`")


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "| " + " | ".join("---" for _ in head) + " |"]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def _cell(text: str) -> str:
    return " ".join(MARKUP.sub("", text).replace("|", "\\|").split())


def _joined(parts: list[str]) -> str:
    return "\n\n".join(part for part in parts if part) + "\n"
