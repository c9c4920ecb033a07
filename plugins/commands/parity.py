"""``harness parity``: how far the simulators differ."""

import typer

from harness.cli.flags.shared import AsJson, PluginFiles
from harness.cli.output import say, say_json
from harness.errors import UsageError

from ..parity import flags


def parity(
    sim: flags.SimulatorNames = None,
    reference: flags.Reference = None,
    robot: flags.RobotName = "fd100",
    steps: flags.Steps = 200,
    episodes: flags.Episodes = 8,
    seed: flags.Seed = 0,
    period: flags.Period = 0.1,
    plugin: PluginFiles = None,
    as_json: AsJson = False,
    html: flags.HtmlFile = None,
) -> None:
    """Drive the same motions through several simulators and show how far they differ. Trains nothing."""
    from harness.registry.given import read_given
    from harness.registry.registry import load_registry
    from harness.robot.load import load_robot

    from ..parity.contenders import choose_contenders
    from ..parity.orders import Setting
    from ..parity.parity import compare_simulators

    _check(steps, episodes, seed, period)
    registry = load_registry(given=read_given(plugin))
    contenders = choose_contenders(registry, sim or [], reference)
    found = compare_simulators(contenders, Setting(load_robot(robot, registry), steps, episodes, seed, period))
    if html is not None:
        from ..parity.page import write_parity

        write_parity(found, html)
        say(f"Page: {html}", err=True)
    if as_json:
        say_json(found.to_json())
    else:
        from harness.cli.terminal import show

        from ..parity.parity_table import parity_table

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
