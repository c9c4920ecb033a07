"""One door for output: nothing but `harness.text` and the tables writes to a terminal, so that all text is visible."""

import ast
from pathlib import Path

import pytest

import harness
from harness.errors import print_visible

ROOT = Path(harness.__file__).parents[1]
ALLOWED = {
    ("harness/text.py", "print"): "the door itself",
    ("harness/text.py", "sys.stderr"): "the door itself",
    ("harness/text.py", "sys.stdout"): "the door itself",
    ("harness/experiment/workers/workers.py", "subprocess"): "a worker leads its standard error to the order's log",
    ("harness/cli/output.py", "sys.stderr"): "a warning of a library, made visible, where Python would write it",
    ("harness/cli/__init__.py", "sys.stdout"): "sets how characters are written that the encoding has not",
    ("harness/cli/app.py", "sys.stdout"): "closes a pipe that nobody reads any more",
    ("harness/experiment/workers/worker.py", "sys.stdout"): "hands it over: what a worker prints goes to its log",
    ("harness/experiment/workers/worker.py", "sys.stderr"): "flushes it, which is the worker's log",
    ("harness/experiment/workers/worker.py", "faulthandler"): "writes a stack of Python into the worker's log",
    ("harness/experiment/trials/tried_plan.py", "faulthandler"): "writes a stack of Python into the worker's log",
    ("harness/face.py", "warnings.warn"): "a sentence of ours with names of ours",
    ("harness/recorder/watched.py", "sys.stdout"): "asks whether it is a terminal, where a browser may be opened",
    ("plugins/kit/unity_player/__main__.py", "sys.stdout"): "a program of its own, whose output is a log",
    ("plugins/kit/unity_player/__main__.py", "sys.stderr"): "a program of its own, whose output is a log",
    ("plugins/bullet_arms/world.py", "sys.stdout"): "flushes it before Bullet's own prints are led elsewhere",
    ("plugins/unity_player/connection.py", "logging"): "a sentence of ours with a number in it",
    ("plugins/slurm_array/cluster.py", "subprocess"): "scancel speaks of numbers of jobs alone",
}
"""Each other way to write: file and way, and why no text of a stranger comes to a terminal there."""

STREAMS = {f"sys.{name}" for name in ("stdout", "stderr", "__stdout__", "__stderr__", "displayhook")}
CALLS = {
    *("print", "input", "pprint.pprint", "pprint", "rich.print", "rich.print_json", "rich.inspect"),
    *("typer.echo", "typer.secho", "typer.echo_via_pager", "typer.prompt", "typer.confirm", "typer.style"),
    *("click.echo", "click.secho", "click.echo_via_pager", "click.prompt", "click.confirm"),
    *("traceback.print_exc", "traceback.print_exception", "traceback.print_stack", "traceback.print_last"),
    *("warnings.showwarning", "os.system", "os.popen", "sys.excepthook"),
}
TO_FILES = {"traceback.print_exc", "traceback.print_exception", "traceback.print_stack", "print", "pprint", "Console"}
"""What writes into a file, and to no terminal, where it gets one."""
RICH = {"Console", "Progress", "Live", "Status", "Prompt", "Confirm"}
"""Classes that write, unless they get the console of `harness.report.tables.grid`, or a file."""
LOGGED = {"debug", "info", "warning", "error", "exception", "critical", "log"}
CHILDREN = {f"subprocess.{name}" for name in ("run", "Popen", "call", "check_call", "check_output")}
TERMINALS = {"/dev/tty", "/dev/stdout", "/dev/stderr", "CONOUT$"}


def ways_to_write(source):
    """Each place in a module that may write to a terminal by itself, by what it calls or names."""
    tree = ast.parse(source)
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    rich = {alias.asname or alias.name for node in imports if (node.module or "")[:4] == "rich" for alias in node.names}
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and _name_of(node) in STREAMS:
            yield _name_of(node)
        elif isinstance(node, ast.ImportFrom):
            yield from _imported(node)
        elif isinstance(node, ast.Constant) and node.value in TERMINALS:
            yield str(node.value)
        elif isinstance(node, ast.Call):
            yield from _called(node, rich & RICH)


def _name_of(node):
    """``a.b`` of an attribute of a name, or the name."""
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        return f"{node.value.id}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else ""


def _imported(node):
    names = {f"{node.module}.{alias.name}" for alias in node.names}
    yield from names & (STREAMS | CALLS | CHILDREN)


def _called(node, rich):
    """Whether a call writes; `rich` are the names of classes of rich that do."""
    name, given = _name_of(node.func), {word.arg for word in node.keywords}
    last = name.rpartition(".")[2]
    if name in CALLS and not (name in TO_FILES and "file" in given and not _goes_to_stream(node)):
        yield name
    if name in rich and not given & {"console", "file"}:
        yield last
    if name.startswith("faulthandler.") and not given & {"file"}:
        yield "faulthandler"
    if _is_logged(node.func) or name == "logging.basicConfig" or last == "StreamHandler":
        yield "logging"
    if name in CHILDREN and not ("capture_output" in given or {"stdout", "stderr"} <= given):
        yield "subprocess"
    if name == "os.write" and node.args and isinstance(node.args[0], ast.Constant):
        yield "os.write"
    if name == "warnings.warn" and not _is_visible(node):
        yield "warnings.warn"


def _goes_to_stream(node):
    files = [word.value for word in node.keywords if word.arg == "file"]
    return any(_name_of(part) in STREAMS for file in files for part in ast.walk(file) if isinstance(part, ast.expr))


def _is_logged(called):
    """``logging.getLogger(...).warning(...)``, ``logger.error(...)``, ``log.info(...)``, ``logging.info(...)``."""
    if not isinstance(called, ast.Attribute) or called.attr not in LOGGED:
        return False
    owner = called.value
    if isinstance(owner, ast.Call):
        return _name_of(owner.func) == "logging.getLogger"
    return _name_of(owner).lower() in {"logging", "logger", "log", "_log", "_logger", "self.log", "self.logger"}


def _is_visible(node):
    """Whether a warning is a text of ours, or was made visible."""
    text = node.args[0]
    is_door = isinstance(text, ast.Call) and _name_of(text.func) in {"visible", "one_line", "_moved"}
    return is_door or isinstance(text, ast.Constant)


def found_in(root):
    """All ways of the packages below a folder: file, way."""
    paths = [path for package in ("harness", "plugins") for path in sorted((root / package).rglob("*.py"))]
    return {(path.relative_to(root).as_posix(), way) for path in paths for way in ways_to_write(path.read_text())}


def test_nothing_else_writes_to_a_terminal():
    """A new way is an error: call `say`, `complain` or `show` of harness.cli, or `harness.text.print_visible`."""
    assert found_in(ROOT) - ALLOWED.keys() == set()


def test_every_exception_is_needed():
    """What is allowed is still there."""
    assert ALLOWED.keys() - found_in(ROOT) == set()


MUTANTS = {
    "print": "print(name)",
    "print to a stream": "import sys\nprint(name, file=sys.stderr)",
    "stream": "import sys\nsys.stdout.write(name)",
    "buffer": "import sys\nsys.stdout.buffer.write(name)",
    "stream by another name": "from sys import stderr\nstderr.write(name)",
    "the first stream": "import sys\nsys.__stderr__.write(name)",
    "typer": "import typer\ntyper.echo(name)",
    "typer's by its name": "from typer import echo\necho(name)",
    "click": "import click\nclick.secho(name)",
    "console": "from rich.console import Console\nConsole().print(name)",
    "rich": "import rich\nrich.print(name)",
    "progress": "from rich.progress import Progress\nProgress()",
    "traceback": "import traceback\ntraceback.print_exc()",
    "warning": "import warnings\nwarnings.warn(f'{name} is odd')",
    "logger": "import logging\nlogging.getLogger(__name__).error(name)",
    "root logger": "import logging\nlogging.warning(name)",
    "process": "import subprocess\nsubprocess.run(['ls'])",
    "shell": "import os\nos.system('ls')",
    "file descriptor": "import os\nos.write(1, name)",
    "terminal": "open('/dev/tty', 'w')",
}


def test_a_way_is_found(subtests):
    """The mutants: whichever way a module writes."""
    for case, source in MUTANTS.items():
        with subtests.test(case):
            assert list(ways_to_write(source))


@pytest.mark.parametrize(
    "source",
    [
        "import traceback\nwith open('log') as log:\n    traceback.print_exc(file=log)",
        "from io import StringIO\nfrom rich.console import Console\nConsole(file=StringIO())",
        "import subprocess\nsubprocess.run(['ls'], capture_output=True)",
        "import warnings\nwarnings.warn(visible(name))",
    ],
)
def test_what_writes_elsewhere_is_none(source):
    """Into a file, into memory, into the harness."""
    assert list(ways_to_write(source)) == []


def test_the_door_writes_what_is_seen(capsys):
    """On either stream; a line break stays one."""
    print_visible("a\x1b]0;b\x07\nc\u202e")
    print_visible("d\x9b", err=True)
    assert tuple(capsys.readouterr()) == ("a\\x1b]0;b\\x07\nc\\u202e\n", "d\\x9b\n")
