"""``harness audit``: what a reward pays for."""

from typing import Annotated

import typer

from harness.cli.options import REWARDS, SIMULATORS, TASKS, PluginFiles, RobotName
from harness.errors import UsageError


def audit(
    reward: Annotated[str, typer.Option(help="The reward, as arp:k2=2.", metavar="NAME", autocompletion=REWARDS)],
    task: Annotated[
        str, typer.Option(help="As fd100-reach:epsilon=0.02.", metavar="NAME", autocompletion=TASKS)
    ] = "fd100-reach",
    robot: RobotName = None,
    sim: Annotated[
        str | None,
        typer.Option(
            help="Simulator; without it no engine: the joints move exactly as told.",
            metavar="NAME",
            autocompletion=SIMULATORS,
        ),
    ] = None,
    against: Annotated[
        str,
        typer.Option(help="The reward that the distance is measured to.", metavar="NAME", autocompletion=REWARDS),
    ] = "baseline",
    episodes: Annotated[int, typer.Option(help="Episodes of each scripted policy.", metavar="N")] = 100,
    gamma: Annotated[float, typer.Option(help="The learner's discount per step.", metavar="G")] = 0.95,
    plugin: PluginFiles = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")] = False,
) -> None:
    """Say what a reward pays for: scripted policies are scored under it, and it is tried on numbers. Trains nothing."""
    from harness.audit.audit import audit_reward
    from harness.audit.rollout import record_rollouts
    from harness.audit.score import score_rollout
    from harness.registry.choice import choose
    from harness.registry.given import read_given
    from harness.registry.registry import load_registry
    from harness.registry.spec import blamed_on
    from harness.robot.load import load_robot
    from harness.testing import IdealSimulator

    if episodes < 1:
        raise UsageError(f"--episodes {episodes}: must be at least 1")
    if not 0.0 < gamma <= 1.0:
        raise UsageError(f"--gamma {gamma:g}: must be above 0 and at most 1")
    registry = load_registry(given=read_given(plugin))
    rewards = [choose(registry, "rewards", name) for name in (reward, against)]
    chosen, where = choose(registry, "tasks", task), sim and choose(registry, "simulators", sim)
    engine = where.build(registry, "simulators") if where else IdealSimulator()
    label = where.label if where else "no engine: joints move exactly as told"
    world = chosen.build(registry, "tasks")
    robot = robot or world.robot
    rollouts = record_rollouts(engine, load_robot(robot, registry), world, episodes)
    judged, other = (choice.build(registry, "rewards") for choice in rewards)
    specs = [registry.get("rewards", choice.name) for choice in rewards]
    with blamed_on(specs[1], "it was audited"):
        score_rollout(other, rollouts[0])
    with blamed_on(specs[0], "it was audited"):
        found = audit_reward(judged, other, rollouts, gamma)
    names = [choice.label for choice in rewards]
    if as_json:
        import json

        from harness.audit.verdict import verdict_of

        setting = {"simulator": label, "robot": robot, "task": chosen.label, "episodes": episodes}
        shown = {"reward": names[0], "against": names[1], **setting, "verdict": verdict_of(found), **found.to_json()}
        typer.echo(json.dumps(shown, indent=1, allow_nan=False))
        return
    from harness.audit.audit_table import audit_table
    from harness.cli.terminal import show

    text = f"{label} · {robot} · {chosen.label} · {episodes} episodes of at most {world.horizon} steps"
    show(audit_table(found, names[0], text, names[1]))
