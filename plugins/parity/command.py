"""``harness parity``: how far the simulators differ."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.flags.shared import ROBOT, ROBOTS, SIMULATORS, AsJson, PluginFiles
from harness.cli.output import say, say_json
from harness.errors import UsageError

SimulatorNames = Annotated[
    list[str] | None,
    typer.Option(
        help="Simulators, such as mujoco:substeps=40.",
        show_default="all",
        metavar="NAME,...",
        autocompletion=SIMULATORS,
    ),
]
Reference = Annotated[
    str | None,
    typer.Option(
        help="The simulator that the others are compared with.",
        show_default="mujoco",
        metavar="NAME",
        autocompletion=SIMULATORS,
    ),
]
RobotName = Annotated[str, typer.Option(help=ROBOT, metavar="NAME", autocompletion=ROBOTS)]
Steps = Annotated[int, typer.Option(help="Control periods of each motion.", metavar="N")]
Episodes = Annotated[int, typer.Option(help="How many motions, and how many dives to the ground.", metavar="N")]
Seed = Annotated[int, typer.Option(help="The seed of the random motions.", metavar="S")]
Period = Annotated[float, typer.Option(help="Control period in seconds.", metavar="T")]
HtmlFile = Annotated[Path | None, typer.Option(help="Write a page with figures to this file.", metavar="FILE")]


def parity(
    sim: SimulatorNames = None,
    reference: Reference = None,
    robot: RobotName = "fd100",
    steps: Steps = 200,
    episodes: Episodes = 8,
    seed: Seed = 0,
    period: Period = 0.1,
    plugin: PluginFiles = None,
    as_json: AsJson = False,
    html: HtmlFile = None,
) -> None:
    """Drive the same motions through several simulators and show how far they differ. Trains nothing."""
    from harness import load_robot
    from harness.registry import load_registry, read_given

    from .contenders import choose_contenders
    from .orders import Setting
    from .parity import compare_simulators

    _check(steps, episodes, seed, period)
    registry = load_registry(given=read_given(plugin))
    contenders = choose_contenders(registry, sim or [], reference)
    found = compare_simulators(contenders, Setting(load_robot(robot, registry), steps, episodes, seed, period))
    if html is not None:
        from .page import write_parity

        write_parity(found, html)
        say(f"Page: {html}", err=True)
    if as_json:
        say_json(found.to_json())
    else:
        from harness.report.tables.grid import show

        from .page import parity_table

        show(parity_table(found))
    if found.failed:
        raise typer.Exit(1)


def _check(steps: int, episodes: int, seed: int, period: float) -> None:
    for flag, number, least in (("--steps", steps, 1), ("--episodes", episodes, 1), ("--seed", seed, 0)):
        if number < least:
            raise UsageError(f"{flag} {number}: must be at least {least}")
    if not 0.0 < period <= 1.0:
        raise UsageError(f"--period {period:g}: must be above 0 and at most 1")


parity.examples = ("harness parity --sim mujoco,pybullet",)  # type: ignore[attr-defined] # harness shows them
