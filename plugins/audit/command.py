"""``harness audit``: what rewards pay for, whatever there is to pay."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from functools import partial as partial_of
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.cli.datasets import names_dataset
from harness.cli.flags.dataset import Partial, Places
from harness.cli.flags.logs import AsFormat, LeftOut, SortBy
from harness.cli.flags.shared import AsJson, FailOn, Measures, PluginFiles, RobotName, TaskName
from harness.cli.output import complain, say, say_json
from harness.errors import UsageError

from .flags import (
    Against,
    Beginner,
    Budget,
    Cluster,
    Episodes,
    FromFolders,
    Gamma,
    HtmlFile,
    LabelsFile,
    OutFolder,
    PolicyNames,
    RandomFolder,
    ReplayFile,
    RewardName,
    SearchSeed,
    SimulatorName,
    Starts,
    Subject,
    Success,
    SuccessAbove,
)

if TYPE_CHECKING:
    from harness.registry import Choice, Registry

    from .audit import Audit
    from .dataset.dataset_audit import DatasetAudit
    from .search.find import Search
    from .search.finding import Finding
    from .search.place import Place
    from .search.world import World

TASK, ENVIRONMENT, EXPERIMENT, RECORDINGS, LOGS, DATASET = (
    "a task", "an environment", "an experiment", "a folder of recorded trainings", "a log", "a data set",
)  # fmt: skip
GOES_WITH: Mapping[str, tuple[str, ...]] = {
    "--robot": (TASK, DATASET),
    "--sim": (TASK,),
    "--success": (ENVIRONMENT, DATASET),
    "--measure": (ENVIRONMENT,),
    **dict.fromkeys(
        ("--against", "--episodes", "--gamma", "--budget", "--starts", "--seed", "--from", "--policy", "--out"),
        (TASK, ENVIRONMENT),
    ),
    "--html": (TASK, ENVIRONMENT, DATASET),
    "--random": (RECORDINGS, EXPERIMENT),
    "--as": (LOGS,),
    "--sort": (LOGS,),
    "--leave-out": (LOGS, RECORDINGS, EXPERIMENT),
}
"""What a flag goes with; --reward, --plugin and --json go with all, and the flags of data sets with them alone."""
NEEDS = {
    "--success": "an ENVIRONMENT or a data set: harness audit gymnasium:id=Pendulum-v1 --success 'NAME>0.9'",
    "--measure": "an ENVIRONMENT: harness audit gymnasium:id=Pendulum-v1 --measure behaviour.py --success 'NAME>0.9'",
    "--random": "a FOLDER of recorded trainings: harness audit FOLDER --random RANDOM",
    "--as": "a FOLDER of logs that other programs wrote: harness audit FOLDER --as NAME",
    "--sort": "a FOLDER of logs that other programs wrote: harness audit FOLDER --sort TEMPLATE",
    "--leave-out": "a FOLDER of trainings: harness audit FOLDER --leave-out PATH",
}


def audit(
    subject: Subject = None,
    reward: RewardName = None,
    task: TaskName = None,
    robot: RobotName = None,
    sim: SimulatorName = None,
    against: Against = None,
    episodes: Episodes = None,
    gamma: Gamma = None,
    budget: Budget = None,
    starts: Starts = None,
    seed: SearchSeed = 0,
    from_folders: FromFolders = None,
    policy: PolicyNames = None,
    random: RandomFolder = None,
    log_format: AsFormat = None,
    sort: SortBy = None,
    leave_out: LeftOut = None,
    places: Places = None,
    success: Success = None,
    measure: Measures = None,
    labels: LabelsFile = None,
    success_above: SuccessAbove = None,
    cluster: Cluster = None,
    partial: Partial = False,
    beginner: Beginner = None,
    html: HtmlFile = None,
    fail_on: FailOn = None,
    out: OutFolder = None,
    replay: ReplayFile = None,
    plugin: PluginFiles = None,
    as_json: AsJson = False,
) -> int:
    """Say what rewards pay for. Trains nothing.

    Of a TASK of an arm: what a cheat would do, and what the reward pays scripted movements and made-up episodes.

    Of an ENVIRONMENT: what a cheat would do, and how far apart rewards are in the steps of random actions.

    Of a FOLDER of trainings, of an experiment, or of logs: what each behaviour was like, what it earned under each
    reward, and how far apart the rewards are on the recorded steps.

    Of a data set: whether each reward ranks recorded behaviour as success does.
    """
    if replay is not None:
        beside = subject or task or reward or ("--fail-on" if fail_on else None)
        return _replayed(replay, sim, plugin, measure, as_json, beside)
    from harness.registry import split_list

    failing: tuple[str, ...] = ()
    if fail_on:  # what decides is loaded where the flag is given
        from harness.cli.fail_on import named_answers

        failing = named_answers(fail_on, "pay", "ranking")
    if subject is not None and task is not None:
        raise UsageError(f"--task {task} does not go with '{subject}': name one of them")
    named = subject or task
    flags = {
        "--places": places, "--labels": labels, "--success-above": success_above,
        "--cluster": cluster, "--partial": partial or None, "--beginner": beginner,
        "--robot": robot, "--sim": sim, "--against": against, "--episodes": episodes, "--gamma": gamma,
        "--random": random, "--as": log_format, "--sort": sort, "--leave-out": leave_out, "--success": success,
        "--measure": measure, "--budget": budget, "--starts": starts, "--seed": seed or None, "--from": from_folders,
        "--policy": policy, "--out": out, "--html": html,
    }  # fmt: skip
    if named is not None and names_dataset(named):
        _refuse_others(DATASET, named, flags)
        from harness.registry import load_registry, read_given

        from .dataset.audit_dataset import audit_dataset

        found = audit_dataset(
            named,
            split_list([reward] if reward else []),
            places=places,
            robot=robot,
            success=success or "",
            labels=labels,
            success_above=success_above,
            cluster=cluster or "",
            partial=partial,
            beginner=beginner,
            registry=load_registry(given=read_given(plugin)),
        )
        return _ended(failing, [found], _show_answer(found, as_json, html))
    from harness.registry import choose, load_registry, read_given, split_measures

    from .audit import audit_table
    from .search.place import GAMMA_OF_ARM, places_in_environment
    from .transitions.audit_rewards import GAMMA

    measures, files = split_measures(measure or ())
    registry = load_registry(given=read_given(plugin, files))
    kind = _kind_of(subject, task, registry)
    _refuse_others(kind, named, flags)
    told = [it for it in (success, *measures) if it is not None]
    if len(told) > 1:
        raise UsageError(f"'{told[0]}' and '{told[1]}' cannot both tell success: leave out one of --success, --measure")
    asked = _asked(kind, budget, starts, seed, from_folders, policy, out, html)
    found_at: Sequence[Place] = ()
    findings: Sequence[Finding] = ()
    discount = gamma if gamma is not None else GAMMA_OF_ARM if kind == TASK else GAMMA
    if kind == TASK:
        audits, found_at = _of_task(registry, reward, named, robot, sim, against, episodes, discount, asked is None)
    elif kind == ENVIRONMENT:
        from .transitions.environment import audit_environment

        chosen = choose(registry, "environments", str(named))
        audits = [audit_environment(chosen, registry, reward, against, discount, episodes)]
        found_at = places_in_environment(registry, chosen, reward, discount, *told)
    else:
        audits = [_of_folder(kind, Path(str(named)), registry, reward, random, log_format, sort, leave_out)]
    if asked is not None:
        from .search.find import cheats_at

        findings = cheats_at(found_at, registry, asked, partial_of(_watched, asked))
        # of a task there is an audit of each reward, of an environment one of all
        each = [findings] if len(audits) == 1 else [(it,) for it in findings]
        audits = [replace(of, cheats=cheats) for of, cheats in zip(audits, each, strict=True)]
    damaged = [f"left out, damaged: {line}" for it in audits for line in it.damaged]
    status = _show(audits, audit_table, as_json, damaged)
    if asked is not None and (out is not None or html is not None):
        _leave(findings, found_at, registry, asked, out, html)
    return _ended(failing, audits, status)


vars(audit)["examples"] = (
    "harness audit --reward arp",
    "harness audit --reward arp:k2=3 --against dense",
    "harness audit gymnasium:id=Pendulum-v1 --plugin my_rewards.py",
    "harness audit my-results",
    "harness audit --reward mine --plugin mine.py --fail-on failing,loitering",
    "harness audit --reward arp --out my-cheats",
    "harness audit --replay my-cheats/arp-failure.json",
)


def _ended(failing: Sequence[str], found: "Sequence[Audit | DatasetAudit]", status: int) -> int:
    """The exit status by what was answered."""
    if not failing:
        return status
    from harness.cli.fail_on import status_of

    return status_of(failing, [said for it in found for said in it.said], status)


def _kind_of(subject: str | None, task: str | None, registry: "Registry") -> str:
    """What is audited.

    Raises:
        UsageError: There is nothing of that name.
    """
    from harness.record import Store
    from harness.registry.choice import kind_of_task, require_known
    from harness.results.recordings.recordings import has_recordings

    if subject is not None and Path(subject).exists():
        folder = Path(subject)
        if folder.is_dir() and Store.is_experiment(folder):
            return EXPERIMENT
        return RECORDINGS if folder.is_dir() and has_recordings(folder) else LOGS
    name = subject or task
    if name is None:
        return TASK
    if kind_of_task(name, registry) == "environments":
        return ENVIRONMENT
    try:
        require_known(name, registry)
    except UsageError as error:
        raise UsageError(
            str(error) if subject is None else f"There is no file or folder '{subject}'. {error}"
        ) from None
    return TASK


def _refuse_others(kind: str, named: str | None, flags: Mapping[str, object]) -> None:
    """Refuse the flags that make no sense of such a subject.

    Raises:
        UsageError: One is given.
    """
    for flag, given in flags.items():
        if given is None or kind in GOES_WITH.get(flag, (DATASET,)):
            continue
        if flag not in GOES_WITH:
            raise UsageError(
                f"{flag} needs a data set: harness audit minari:NAME, lerobot:FOLDER, d4rl:FILE or robomimic:FILE"
            )
        if kind == TASK:
            raise UsageError(f"{flag} needs {NEEDS[flag]}")
        raise UsageError(f"{flag} does not go with {kind}: leave out {flag} or '{named}'")


def _asked(
    kind: str,
    budget: int | None,
    starts: int | None,
    seed: int,
    folders: Sequence[Path] | None,
    policies: Sequence[str] | None,
    out: Path | None,
    html: Path | None,
) -> "Search | None":
    """How much is searched; None for nothing.

    Raises:
        UsageError: A number is too small, nothing is searched whose finding could be written, or it cannot be written.
    """
    if budget == 0 or kind not in (TASK, ENVIRONMENT):
        for flag, place in (("--out", out), ("--html", html)):
            if place is not None:
                raise UsageError(f"{flag} needs a search: leave out --budget 0")
        return None
    from .search.find import ARM, ENVIRONMENT as ANY, Search

    usual = ARM if kind == TASK else ANY
    for flag, given, least in (("--budget", budget, 0), ("--starts", starts, 1), ("--seed", seed, 0)):
        if given is not None and given < least:
            raise UsageError(f"{flag} {given}: must be at least {least}")
    if html is not None and (html.is_dir() or not html.parent.is_dir()):
        raise UsageError(f"--html '{html}': name a file in a folder that exists, such as page.html")
    if out is not None:
        from .search.out import require_free

        require_free(out)
    return Search(
        usual.budget if budget is None else budget,
        usual.starts if starts is None else starts,
        seed,
        tuple(folders or ()),
        tuple(policies or ()),
    )


def _leave(
    findings: "Sequence[Finding]",
    places: "Sequence[Place]",
    registry: "Registry",
    asked: "Search",
    out: Path | None,
    html: Path | None,
) -> None:
    """Certify what was found, and leave it in a folder, or its page in a file."""
    from .search.out import certificates_of, write_found, write_found_page

    certificates, refused = certificates_of(findings, places, registry, seed=asked.seed, budget=asked.budget)
    for line in refused:
        complain(line)
    if out is not None:
        write_found(out, certificates, registry, refused)
        say(f"Certificates: {out}, their page: {out / 'index.html'}", err=True)
    if html is not None:
        write_found_page(html, certificates, registry, refused)
        say(f"Page: {html}", err=True)


def _replayed(
    path: Path,
    sim: str | None,
    plugin: Sequence[str] | None,
    measure: Sequence[str] | None,
    as_json: bool,
    other: str | None,
) -> int:
    """Play a certificate again, and say whether it is paid the same; status 1 if it is not.

    Raises:
        UsageError: Something else is to be audited too.
    """
    if other is not None:
        raise UsageError(f"--replay {path} says itself what is played: leave out '{other}'")
    from harness.registry import load_registry, read_given, split_measures

    from .search.out import replay_file

    found = replay_file(path, load_registry(given=read_given(plugin, split_measures(measure or ())[1])), sim)
    if as_json:
        say_json(found.to_json())
    else:
        for line in found.lines:
            say(line)
    return 1 if found.is_refused else 0


@contextmanager
def _watched(asked: "Search", world: "World") -> Iterator[None]:
    """On a terminal, a line on standard error that says how much of a world was searched."""
    from rich.text import Text

    from harness.report.tables.grid import Terminal

    class Taken:
        """The line, anew whenever it is drawn."""

        def __rich__(self) -> Text:
            return Text(f"{world.reward}: {world.taken:,} steps of about {asked.budget:,}")

    console = Terminal(stderr=True)
    with console.status(Taken()) if console.is_terminal else nullcontext():
        yield


def _show(found: Sequence[Any], table: Callable[[Any], Any], as_json: bool, wrong: Sequence[str]) -> int:
    """Print what was found, and what is wrong, a line each; status 1 where something is."""
    if as_json:
        say_json(found[0].to_json() if len(found) == 1 else [it.to_json() for it in found])
    else:
        from harness.report.tables.grid import show

        for number, it in enumerate(found):
            if number:
                say("")
            show(table(it))
    for line in wrong:
        complain(line)
    return 1 if wrong else 0


def _of_folder(
    kind: str,
    folder: Path,
    registry: "Registry",
    reward: str | None,
    random: Path | None,
    log_format: str | None,
    sort: str | None,
    leave_out: Sequence[Path] | None,
) -> "Audit":
    """What lies in a folder: recordings of an experiment or loose ones, cells of an arm, or logs of other programs."""
    from harness.registry import split_list

    from .recorded.recordings import audit_logs, audit_recordings, held_back

    out = tuple(leave_out or ())
    only = split_list(reward) if reward else []
    if kind == LOGS:
        from harness.log.open_log import find_logs

        return audit_logs(folder, find_logs(folder, registry, log_format or ""), only, sort or "", out)
    if kind == EXPERIMENT:
        from harness import load_results
        from harness.results.logs.told import Told
        from harness.results.traces import Traces

        results = load_results(folder, told=Told(leave_out=out), registry=registry)
        if isinstance(results, Traces):
            from harness.cli.output import audits_of

            from .recorded.experiment import audit_experiment

            if random is not None:
                raise UsageError(f"--random does not go with '{folder}', whose own cells acted at random: leave it out")
            audit = audit_experiment(results, only)
            scripted = dict.fromkeys(
                f"{label}: {' '.join(payoffs.verdict)}"
                for (_, _, label), payoffs in audits_of(results).items()
                if label in audit.rewards
            )
            return held_back(replace(audit, verdict=(*audit.verdict, *scripted)), results.account)
        return audit_recordings(folder, random, only, account=results.account)
    return audit_recordings(folder, random, only, out)


def _of_task(
    registry: "Registry",
    rewards: str | None,
    task: str | None,
    robot: str | None,
    sim: str | None,
    against: str | None,
    episodes: int | None,
    gamma: float,
    needs_scripts: bool,
) -> "tuple[list[Audit], list[Place]]":
    """An audit of each reward by scripts, where they can do the task, and where a search looks."""
    from harness.env.ideal import IdealSimulator
    from harness.payoff.rollout import NoScriptsError, record_rollouts, score_rollout
    from harness.registry import choose, split_list
    from harness.task import choose_task

    from .audit import Audit
    from .scripts import audit_reward
    from .search.disturb import NOISES
    from .search.place import places_on_task

    if rewards is None:
        raise UsageError("Missing option '--reward'; or name an environment, or a folder of recorded trainings")
    choices = [choose(registry, "rewards", name) for name in split_list(rewards)]
    episodes = 100 if episodes is None else episodes
    if episodes < 1:
        raise UsageError(f"--episodes {episodes}: must be at least 1")
    if not 0.0 < gamma <= 1.0:
        raise UsageError(f"--gamma {gamma:g}: must be above 0 and at most 1")
    compared = choose(registry, "rewards", against or "baseline")
    chosen, arm = choose_task(registry, task or "fd100-reach", robot)
    where = sim and choose(registry, "simulators", sim)
    engine = where.build(registry, "simulators") if where else IdealSimulator()
    label = where.label if where else "no simulator: joints move exactly as commanded"
    world = chosen.build(registry, "tasks")
    places = places_on_task(registry, choices, task or "fd100-reach", robot, sim, gamma)
    try:
        rollouts = record_rollouts(engine, arm, world, episodes)
        disturbed = record_rollouts(engine, arm, world, episodes, NOISES[-1])
    except NoScriptsError as error:
        if needs_scripts:
            raise
        facts, unasked = {"task": str(task)}, (f"Not asked of scripts: {error}.",)
        return [
            Audit(title=it.label, facts={"reward": it.label, **facts}, rewards=(it.label,), not_asked=unasked)
            for it in choices
        ], places
    *judged, other = (choice.build(registry, "rewards") for choice in (*choices, compared))
    with _named(compared, registry):
        score_rollout(other, rollouts[0])
    robot = robot or world.robot
    setting = f"{label} · {robot} · {chosen.label} · {episodes} episodes of at most {world.horizon} steps"
    told = {"simulator": label, "robot": robot, "task": chosen.label, "episodes": episodes}
    found = []
    for choice, reward in zip(choices, judged, strict=True):
        with _named(choice, registry):
            audit = audit_reward(reward, other, rollouts, gamma, (choice.label, compared.label), setting, disturbed)
        found.append(replace(audit, facts={"reward": choice.label, "against": compared.label, **told}))
    return found, places


@contextmanager
def _named(choice: "Choice", registry: "Registry") -> Iterator[None]:
    """Whatever a reward raises in this block is said to be the reward's."""
    from harness.registry.spec import blamed_on

    try:
        with blamed_on(registry.get("rewards", choice.name), "it was audited"):
            yield
    except UsageError as error:
        raise UsageError(f"Reward '{choice.label}': {error}") from error


def _show_answer(found: "DatasetAudit", as_json: bool, html: Path | None) -> int:
    """Print what was found, and write its page; status 1 where a reward could not pay."""
    from .dataset.dataset_audit import answer_table

    if html is not None:
        from .dataset.page import write_dataset_page

        write_dataset_page(found, html)
        say(f"Page: {html}", err=True)
    return _show([found], answer_table, as_json, [f"reward {name}: n/a ({why})" for name, why in found.failed.items()])
