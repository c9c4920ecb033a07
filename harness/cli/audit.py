"""``harness audit``: what a reward pays for, what the rewards of recorded trainings paid, and rewards on data sets."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from harness.cli.datasets import audit_rewards_on, names_dataset, show_answer
from harness.cli.flags import audit as flags
from harness.cli.flags import dataset as of_dataset
from harness.cli.flags.shared import AsJson, Names, PluginFiles, RecordedFolder, RobotName, TaskName
from harness.cli.output import complain, say, say_json
from harness.errors import UsageError

if TYPE_CHECKING:
    from harness.registry.choice import Choice
    from harness.registry.registry import Registry


def audit(
    folder: RecordedFolder = None,
    reward: flags.RewardName = None,
    task: TaskName = None,
    robot: RobotName = None,
    sim: flags.SimulatorName = None,
    against: flags.Against = None,
    episodes: flags.Episodes = None,
    gamma: flags.Gamma = None,
    random: flags.RandomFolder = None,
    places: of_dataset.Places = None,
    success: of_dataset.Success = None,
    labels: of_dataset.LabelsFile = None,
    success_above: of_dataset.SuccessAbove = None,
    cluster: of_dataset.Cluster = None,
    partial: of_dataset.Partial = False,
    beginner: of_dataset.Beginner = None,
    html: of_dataset.HtmlFile = None,
    plugin: PluginFiles = None,
    as_json: AsJson = False,
) -> int:
    """Say what a reward pays for. The reward and its terms pay scripted movements and made-up episodes. Trains nothing.

    With a FOLDER of recorded trainings: say how far apart the rewards are on the recorded steps, and what each trained
    behaviour earned under each reward.

    With a data set, minari:NAME or lerobot:FOLDER: say of each reward whether it ranks recorded behaviour as success
    does. Rewards are the recorded ones and functions of --plugin, or those of --reward.
    """
    if folder is not None and names_dataset(folder):
        from harness.registry.choice import split_list

        beside = {"--task": task, "--sim": sim, "--against": against, "--episodes": episodes, "--gamma": gamma}
        _refuse_beside(folder, {**beside, "--random": random}, "a data set")
        names = split_list([reward] if reward else [])
        found = audit_rewards_on(
            folder,
            names,
            plugin,
            places=places,
            robot=robot,
            success=success,
            labels=labels,
            success_above=success_above,
            cluster=cluster,
            partial=partial,
            beginner=beginner,
        )
        return show_answer(found, as_json, html)
    of_datasets = {
        "--places": places, "--success": success, "--labels": labels, "--success-above": success_above,
        "--cluster": cluster, "--partial": partial or None, "--beginner": beginner, "--html": html,
    }  # fmt: skip
    for flag, given in of_datasets.items():
        if given is not None:
            raise UsageError(f"{flag} needs a data set: harness audit minari:NAME, or harness audit lerobot:FOLDER")
    if folder is not None:
        _refuse_beside(
            folder,
            {
                "--reward": reward, "--task": task, "--robot": robot, "--sim": sim, "--against": against,
                "--episodes": episodes, "--gamma": gamma, "--plugin": plugin,
            },
        )  # fmt: skip
        return _audit_folder(folder, random, as_json)
    if random is not None:
        raise UsageError("--random needs a FOLDER of recorded trainings: harness audit FOLDER --random RANDOM")
    if reward is None:
        raise UsageError("Missing option '--reward'; or name a folder of recorded trainings")
    _audit_rewards(
        reward,
        "fd100-reach" if task is None else task,
        robot,
        sim,
        "baseline" if against is None else against,
        100 if episodes is None else episodes,
        0.95 if gamma is None else gamma,
        plugin,
        as_json,
    )
    return 0


def _refuse_beside(folder: Path, beside: Mapping[str, object], noun: str = "a folder of recorded trainings") -> None:
    for flag, given in beside.items():
        if given is not None:
            raise UsageError(f"{flag} does not go with {noun}: leave out {flag} or '{folder}'")


def _audit_folder(folder: Path, random: Path | None, as_json: bool) -> int:
    """Status 1 where a recording is damaged."""
    from harness.audit.recorded.recordings import audit_recordings

    found = audit_recordings(folder, random)
    if as_json:
        say_json(found.to_json())
    else:
        from harness.audit.recorded.recorded_table import recorded_table
        from harness.cli.terminal import show

        show(recorded_table(found))
    for line in found.damaged:
        complain(f"left out, damaged: {line}")
    return 1 if found.damaged else 0


def _audit_rewards(
    rewards: str,
    task: str,
    robot: str | None,
    sim: str | None,
    against: str,
    episodes: int,
    gamma: float,
    plugin: Names,
    as_json: bool,
) -> None:
    from harness.audit.audit import audit_reward
    from harness.audit.rollout import record_rollouts
    from harness.audit.score import score_rollout
    from harness.env.ideal import IdealSimulator
    from harness.registry.choice import choose, split_list
    from harness.registry.given import read_given
    from harness.registry.registry import load_registry
    from harness.robot.load import load_robot

    if episodes < 1:
        raise UsageError(f"--episodes {episodes}: must be at least 1")
    if not 0.0 < gamma <= 1.0:
        raise UsageError(f"--gamma {gamma:g}: must be above 0 and at most 1")
    registry = load_registry(given=read_given(plugin))
    *choices, compared = (choose(registry, "rewards", name) for name in (*split_list(rewards), against))
    chosen, where = choose(registry, "tasks", task), sim and choose(registry, "simulators", sim)
    engine = where.build(registry, "simulators") if where else IdealSimulator()
    label = where.label if where else "no simulator: joints move exactly as commanded"
    world = chosen.build(registry, "tasks")
    robot = robot or world.robot
    rollouts = record_rollouts(engine, load_robot(robot, registry), world, episodes)
    *judged, other = (choice.build(registry, "rewards") for choice in (*choices, compared))
    with _named(compared, registry):
        score_rollout(other, rollouts[0])
    found = []
    for choice, reward in zip(choices, judged, strict=True):
        with _named(choice, registry):
            found.append(audit_reward(reward, other, rollouts, gamma))
    if as_json:
        from harness.audit.verdict import verdict_of

        setting = {"simulator": label, "robot": robot, "task": chosen.label, "episodes": episodes}
        shown = [
            {"reward": choice.label, "against": compared.label, **setting, "verdict": verdict_of(it), **it.to_json()}
            for choice, it in zip(choices, found, strict=True)
        ]
        say_json(shown if len(shown) > 1 else shown[0])
        return
    from harness.audit.audit_table import audit_table
    from harness.cli.terminal import show

    text = f"{label} · {robot} · {chosen.label} · {episodes} episodes of at most {world.horizon} steps"
    for number, (choice, it) in enumerate(zip(choices, found, strict=True)):
        if number:
            say("")
        show(audit_table(it, choice.label, text, compared.label))


@contextmanager
def _named(choice: "Choice", registry: "Registry") -> Iterator[None]:
    """Whatever a reward raises in this block is said to be the reward's."""
    from harness.registry.spec import blamed_on

    try:
        with blamed_on(registry.get("rewards", choice.name), "it was audited"):
            yield
    except UsageError as error:
        raise UsageError(f"Reward '{choice.label}': {error}") from error
