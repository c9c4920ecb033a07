"""A flag that would say nothing of what a command is given is refused, at every door and with every kind of input."""

import shutil

import pytest

from harness.cli.app import build_app
from harness.cli.flags.inputs import FITTING
from tests.cli.test_refused import place  # noqa: F401 the folders of these lines
from tests.registered import REGISTRY

PATHS = {
    "report": ["mine", "env", "runs", "logs", "minari:m", "rec"],
    "eta": ["mine", "runs", "logs", "s", "--baseline base/0.csv --proposed k2/0.csv"],
    "score": ["mine", "runs", "minari:m", "mine/cells/*/trace.parquet"],
    "audit": ["fd100-reach", "CartPole-v1", "mine", "runs", "logs", "--replay x.json", "minari:m"],
}
"""What stands behind each command, a line for each kind that it tells apart."""
NUMBERS = dict.fromkeys(("--budget", "--starts", "--seed", "--episodes", "--gamma", "--success-above"), "1")
VALUES = {"--curve": "per-step", "--fail-on": "hurts", "--plugin": "own.py", "--measure": "own.py", **NUMBERS}
SWITCHES = ("--details", "--pairs", "--json", "--with-events", "--all", "--partial")


def flags_of(command):
    """All flags of a command with a value that it reads."""
    import typer
    from typer.main import get_command_from_info

    app = build_app()
    if command in REGISTRY.names("commands"):  # one of a plugin
        app = typer.Typer()
        app.command(command)(REGISTRY.get("commands", command).load())
    (found,) = (it for it in app.registered_commands if it.callback.__name__ == command)
    made = get_command_from_info(found, pretty_exceptions_short=False, rich_markup_mode=None)
    return sorted(it.opts[0] for it in made.params if it.opts[0].startswith("--") and it.opts[0] != "--help")


@pytest.fixture
def places(place, harness, tmp_path):  # noqa: F811
    """The same, and records, an experiment in an environment, and a folder of CSV files of steps."""
    harness("report mine --summary rec")
    line = "run --task gymnasium:id=CartPole-v1 --algo random --baseline none --reward own --seeds 1 --steps 60"
    assert harness(f"{line} --evaluation-episodes 2 --executor here --out env").status == 0
    for name in ("base", "k2"):
        shutil.copytree(tmp_path / name, tmp_path / "s" / name)


@pytest.mark.parametrize("command", FITTING)
def test_every_flag_is_read_or_refused(places, refused, command, subtests):
    """What no kind reads is no flag; what one kind does not read is refused there, and named."""
    flags, kinds = flags_of(command), FITTING[command]
    assert {it for of in kinds.values() for it in of.split()} == set(flags) - {"--help-all"}
    for path, (kind, fitting) in zip(PATHS[command], kinds.items(), strict=True):
        for flag in {*flags} - {*fitting.split(), "--help-all", "--proposed"}:
            value = "" if flag in SWITCHES else VALUES.get(flag, "a=1,2")
            with subtests.test(kind=kind, flag=flag):
                told = refused(f"{command} {path} {flag} {value}")
                assert flag in told
                assert "leave it out" in told or "holds only records" in told
