"""``harness bench``: where the time of a cell goes, and how fast plugins are beside what they are built on."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from harness.authoring.commands import (
    ALGORITHMS,
    REWARDS,
    AsJson,
    EvaluationEpisodes,
    PluginFiles,
    RobotName,
    SimulatorNames,
    TaskName,
    say,
    say_json,
)
from harness.errors import SchemaError, UsageError

if TYPE_CHECKING:
    from harness.authoring.commands import Plan, Registry

    from .cells import Bench
    from .speeds import SpeedChanges, Speeds

CELL_ROUNDS, SPEED_ROUNDS = 3, 9
"""How many processes time everything where nobody says: the cells, and all else."""

Tables = Annotated[
    list[str] | None,
    typer.Argument(
        help="cells: where the time of a training goes. simulators: speed compared with the bare engine. "
        "algorithms: speed compared with the bare library. peers: speed compared with other projects.",
        show_default="cells",
        metavar="WHAT",
    ),
]
Names = list[str] | None
AlgorithmNames = Annotated[
    Names,
    typer.Option(
        help="Algorithms to time, such as sac:net_arch=256x256.", metavar="NAME,...", autocompletion=ALGORITHMS
    ),
]
RewardNames = Annotated[
    Names,
    typer.Option(help="Rewards to time.", show_default="baseline", metavar="NAME,...", autocompletion=REWARDS),
]
Steps = Annotated[
    int | None,
    typer.Option(
        help="Environment steps of each training.", show_default="2000; for algorithms and peers 256", metavar="N"
    ),
]
NumEnvs = Annotated[
    str | None,
    typer.Option(help="For simulators: how many arms they move at once.", show_default="1,64,1024", metavar="N,..."),
]
Rounds = Annotated[
    int | None,
    typer.Option(
        help="How many processes, one after the other, time everything.",
        show_default=f"{CELL_ROUNDS}; for simulators, algorithms and peers {SPEED_ROUNDS}",
        metavar="N",
    ),
]
OldFile = Annotated[
    Path | None,
    typer.Option(
        help="Measure again what this file holds. Ends with status 1 if something became slower.",
        metavar="OLD.json",
    ),
]
HtmlFile = Annotated[Path | None, typer.Option(help="Write a page with a figure to this file.", metavar="FILE")]


WHAT = ("cells", "simulators", "algorithms", "peers")


def bench(
    what: Tables = None,
    sim: SimulatorNames = None,
    algo: AlgorithmNames = None,
    reward: RewardNames = None,
    task: TaskName = None,
    robot: RobotName = None,
    steps: Steps = None,
    evaluation_episodes: EvaluationEpisodes = None,
    num_envs: NumEnvs = None,
    rounds: Rounds = None,
    compare: OldFile = None,
    plugin: PluginFiles = None,
    as_json: AsJson = False,
    html: HtmlFile = None,
) -> int:
    """Show where the time of a training goes, or how fast plugins are compared with bare engines and libraries."""
    if rounds is not None and rounds < 1:
        raise UsageError(f"--rounds {rounds}: must be at least 1")
    if compare is not None:
        of_old = {"WHAT": what, "--sim": sim, "--algo": algo, "--task": task, "--robot": robot, "--steps": steps}
        others = {"--reward": reward, "--evaluation-episodes": evaluation_episodes, "--num-envs": num_envs}
        _refuse({**of_old, **others}, "--compare measures what OLD.json holds, as it was measured then")
        return _again(compare, rounds, plugin, as_json, html)
    if not what or what == ["cells"]:
        _refuse({"--num-envs": num_envs, "--html": html}, "only 'harness bench simulators' takes it")
        given = {
            "sim": sim, "algo": algo, **_rewards(reward), "task": task, "robot": robot, "seeds": [0],
            "steps": 2000 if steps is None else steps,
            "evaluation_episodes": 100 if evaluation_episodes is None else evaluation_episodes,
        }  # fmt: skip
        return _cells({key: value for key, value in given.items() if value is not None}, rounds, plugin, as_json)
    _check(what)
    if "cells" in what:
        raise UsageError("cells are timed alone: time the others with a second command")
    cells_alone = {"--reward": reward, "--evaluation-episodes": evaluation_episodes}
    _refuse(cells_alone, "only 'harness bench cells' takes it")
    return _speeds(what, sim or [], algo or [], task, robot, steps, num_envs, rounds, plugin, as_json, html)


def _check(what: list[str]) -> None:
    from harness.authoring.commands import unknown_name

    for word in what:
        if word not in WHAT:
            raise UsageError(unknown_name("table of harness bench", word, WHAT))


def _refuse(options: dict[str, Any], reason: str) -> None:
    for name, value in options.items():
        if value is not None:
            raise UsageError(f"{name}: {reason}. Leave it out")


def _rewards(given: Names) -> dict[str, Any]:
    """The first one stands as the baseline, so that no other is trained beside those that were named."""
    from harness.authoring.commands import split_list

    names = split_list(given or []) or ["baseline"]
    return {"reward": names[1:], "baseline": names[0]}


def _cells(given: dict[str, Any], rounds: int | None, plugin: Names, as_json: bool) -> int:
    from harness.authoring.commands import check_experiment, expand, load_registry, read_given

    experiment = check_experiment(given, "bench")
    registry = load_registry(given=read_given(plugin))
    found = _measure(expand(experiment, registry), registry, rounds or CELL_ROUNDS)
    if as_json:
        say_json(found.to_json())
    else:
        from harness.authoring.commands import show

        from .cells import bench_table

        show(bench_table(found))
    return 1 if found.failed else 0


def _measure(plan: "Plan", registry: "Registry", rounds: int) -> "Bench":
    from harness.authoring.commands import LiveProgress

    from .cells import measure

    with LiveProgress(plan.cells * rounds, ()) as progress:
        return measure(plan, registry, rounds, progress)


def _speeds(
    what: list[str],
    sim: list[str],
    algo: list[str],
    task: str | None,
    robot: str | None,
    steps: int | None,
    num_envs: str | None,
    rounds: int | None,
    plugin: Names,
    as_json: bool,
    html: Path | None,
) -> int:
    from harness.authoring.commands import load_registry, read_given

    from .contests import KINDS, Setting
    from .measure import SIZES, measure_speeds, plan_entries

    if steps is not None and steps < 1:
        raise UsageError(f"--steps {steps}: must be at least 1")
    sizes = SIZES if num_envs is None else _sizes(num_envs)
    registry = load_registry(given=read_given(plugin))
    entries, left_out = plan_entries(registry, [kind for kind in KINDS if kind in what], sim, algo, sizes)
    usual = Setting()
    setting = Setting(robot, usual.task if task is None else task, usual.steps if steps is None else steps)
    found = measure_speeds(registry, entries, left_out, setting, rounds or SPEED_ROUNDS, _tell)
    _show(found, None, as_json, html)
    return 1 if found.failed else 0


def _again(path: Path, rounds: int | None, plugin: Names, as_json: bool, html: Path | None) -> int:
    from harness.authoring.commands import load_registry, read_given

    from .measure import measure_speeds
    from .speeds import FEWEST_ROUNDS, compare_speeds, read_speeds

    try:
        old = read_speeds(path)
    except OSError as error:
        raise UsageError(f"'{path}' cannot be read: {error.strerror}") from error
    except SchemaError as error:  # no results of ours are damaged: another file was named than is meant
        raise UsageError(str(error)) from error
    times = old.rounds if rounds is None else rounds
    for number, whose in ((old.rounds, f"'{path}' has"), (times, "--rounds gives")):
        if number < FEWEST_ROUNDS:
            raise UsageError(f"{whose} {number} rounds: at least {FEWEST_ROUNDS} are needed to estimate the noise")
    found = measure_speeds(
        load_registry(given=read_given(plugin)), [speed.entry for speed in old.speeds], (), old.setting, times, _tell
    )
    comparison = compare_speeds(old, found)
    _show(found, comparison, as_json, html)
    return 1 if found.failed or comparison.slower else 0


def _sizes(given: str) -> list[int]:
    try:
        sizes = [int(number) for number in given.split(",")]
    except ValueError:
        sizes = []
    if not sizes or min(sizes) < 1:
        raise UsageError(f"--num-envs {given}: give numbers from 1 on, such as 1,64,1024")
    return list(dict.fromkeys(sizes))


def _tell(number: int, count: int, title: str) -> None:
    say(f"[{number}/{count}] {title}", err=True)


def _show(found: "Speeds", comparison: "SpeedChanges | None", as_json: bool, html: Path | None) -> None:
    if html is not None:
        from .tables import write_speed_page

        write_speed_page(found, comparison, html)
        say(f"Page: {html}", err=True)
    if as_json:
        say_json({**found.to_json(), **({"comparison": comparison.to_json()} if comparison else {})})
    else:
        from harness.authoring.commands import show

        from .tables import speed_table

        show(speed_table(found, comparison))


bench.examples = (  # type: ignore[attr-defined] # harness shows them
    "harness bench --sim mujoco --algo sac",
    "harness bench simulators --sim mujoco --num-envs 1,64",
    "harness bench simulators algorithms --json > before.json",
    "harness bench --compare before.json",
)
