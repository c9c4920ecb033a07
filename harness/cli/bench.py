"""``harness bench``: where the time of a cell goes."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from harness.cli.options import ALGORITHMS, REWARDS, SIMULATORS, Names, RobotName, TaskName
from harness.errors import UsageError

if TYPE_CHECKING:
    from harness.bench.bench import Bench
    from harness.experiment.plan import Plan
    from harness.registry.registry import Registry


def bench(
    sim: Annotated[Names, typer.Option(help="Simulators.", metavar="NAME,...", autocompletion=SIMULATORS)] = None,
    algo: Annotated[
        Names, typer.Option(help="Algorithms, as sac:net_arch=256x256.", metavar="NAME,...", autocompletion=ALGORITHMS)
    ] = None,
    reward: Annotated[
        Names, typer.Option(help="Rewards.", show_default="baseline", metavar="NAME,...", autocompletion=REWARDS)
    ] = None,
    task: TaskName = None,
    robot: RobotName = None,
    steps: Annotated[int, typer.Option(help="Environment steps of each training.", metavar="N")] = 2000,
    evaluation_episodes: Annotated[int, typer.Option(help="Episodes of an evaluation.", metavar="N")] = 100,
    rounds: Annotated[int, typer.Option(help="Trainings of each combination, in turns.", metavar="N")] = 3,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")] = False,
) -> int:
    """Train each combination as harness run does, and show where the time goes. Keeps nothing."""
    from harness.experiment.plan import check_experiment, expand
    from harness.registry.registry import load_registry

    if rounds < 1:
        raise UsageError(f"--rounds {rounds}: must be at least 1")
    given = {
        "sim": sim, "algo": algo, **_rewards(reward), "task": task, "robot": robot, "seeds": [0], "steps": steps,
        "evaluation_episodes": evaluation_episodes,
    }  # fmt: skip
    experiment = check_experiment({key: value for key, value in given.items() if value is not None}, "bench")
    registry = load_registry()
    found = _measure(expand(experiment, registry), registry, rounds)
    _show(found, as_json)
    return 1 if found.failed else 0


def _rewards(given: Names) -> dict[str, Any]:
    """The first one stands as the baseline, so that no other is trained beside those that were named."""
    from harness.registry.choice import split_list

    names = split_list(given or []) or ["baseline"]
    return {"reward": names[1:], "baseline": names[0]}


def _measure(plan: "Plan", registry: "Registry", rounds: int) -> "Bench":
    from harness.bench.bench import measure
    from harness.cli.progress import LiveProgress

    with LiveProgress(plan.cells * rounds, ()) as progress:
        return measure(plan, registry, rounds, progress)


def _show(found: "Bench", as_json: bool) -> None:
    if as_json:
        import json

        typer.echo(json.dumps(found.to_json(), indent=1, allow_nan=False))
    else:
        from harness.bench.bench_table import bench_table
        from harness.cli.terminal import show

        show(bench_table(found))
