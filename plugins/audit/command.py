"""``harness audit``: what rewards pay for, whatever there is to pay."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from functools import partial as partial_of
from pathlib import Path
from pkgutil import resolve_name
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import typer

from harness.cli.datasets import names_dataset
from harness.cli.flags.dataset import Partial, Places
from harness.cli.flags.inputs import (
    ANY_EXPERIMENT,
    CERTIFICATE,
    DATASET,
    ENVIRONMENT,
    LOGS,
    RECORDINGS,
    TASK,
    require_fit,
)
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
from .subject import Asked

if TYPE_CHECKING:
    from harness.registry import Registry

    from .search.find import Search
    from .search.finding import Finding
    from .search.world import World

SUBJECTS = {
    TASK: ".scripts:audited",
    ENVIRONMENT: ".transitions.environment:audited",
    ANY_EXPERIMENT: ".recorded.experiment:audited",
    RECORDINGS: ".recorded.recordings:audited",
    LOGS: ".recorded.recordings:audited_logs",
    DATASET: ".dataset.audit_dataset:audited",
}
"""By what is audited, the function that does it, from `Asked` to `Answered`; the others are not imported."""


def audit(
    context: typer.Context,
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
    if replay is not None and subject is None:
        require_fit(context, CERTIFICATE)
        return _replayed(replay, sim, plugin, measure, as_json)
    from harness.registry import load_registry, read_given, split_list, split_measures

    failing: tuple[str, ...] = ()
    if fail_on:  # what decides is loaded where the flag is given
        from harness.cli.fail_on import named_answers

        failing = named_answers(fail_on, "pay", "ranking")
    if subject is not None and task is not None:
        raise UsageError(f"--task {task} does not go with '{subject}': name one of them")
    measures, files = split_measures(measure or ())
    registry = load_registry(given=read_given(plugin, files))
    kind = _kind_of(subject, task, registry)
    require_fit(context, kind)
    told = [*filter(None, (success, *measures))]
    if len(told) > 1:
        raise UsageError(f"'{told[0]}' and '{told[1]}' cannot both tell success: leave out one of --success, --measure")
    asked = Asked(
        registry=registry,
        named=subject or task or "fd100-reach",
        rewards=split_list(reward or []),
        robot=robot,
        sim=sim,
        against=against,
        episodes=episodes,
        gamma=gamma,
        search=_search_of(kind, budget, starts, seed, from_folders, policy, out, html),
        random=random,
        log_format=log_format or "",
        sort=sort or "",
        leave_out=tuple(leave_out or ()),
        places=places,
        success=told[0] if told else "",
        labels=labels,
        success_above=success_above,
        cluster=cluster or "",
        partial=partial,
        beginner=beginner,
    )
    audits, at = resolve_name(f"{__package__}{SUBJECTS[kind]}")(asked)
    search, findings = asked.search, tuple["Finding", ...]()
    if search is not None:
        from .search.find import cheats_at

        findings = cheats_at(at, registry, search, partial_of(_watched, search))
        # of a task there is an audit of each reward, of an environment one of all
        each = [findings] if len(audits) == 1 else [(it,) for it in findings]
        audits = [replace(of, cheats=cheats) for of, cheats in zip(audits, each, strict=True)]
    status = _show(audits, as_json)
    if search is not None and (out or html):
        from .search.out import certificates_of, write_found, write_found_page

        certificates, refused = certificates_of(findings, at, registry, seed=search.seed, budget=search.budget)
        for line in refused:
            complain(line)
        if out is not None:
            write_found(out, certificates, registry, refused)
            say(f"Certificates: {out}, their page: {out / 'index.html'}", err=True)
        if html is not None:
            write_found_page(html, certificates, registry, refused)
    elif html is not None:
        from .dataset.page import write_dataset_page

        write_dataset_page(audits[0], html)
    if html is not None:
        say(f"Page: {html}", err=True)
    if not failing:
        return status
    from harness.cli.fail_on import status_of

    return status_of(failing, [said for it in audits for said in it.said], status)


vars(audit)["examples"] = (
    "harness audit --reward arp",
    "harness audit --reward arp:k2=3 --against dense",
    "harness audit gymnasium:id=Pendulum-v1 --plugin my_rewards.py",
    "harness audit my-results",
    "harness audit --reward mine --plugin mine.py --fail-on failing,loitering",
    "harness audit --reward arp --out my-cheats",
    "harness audit --replay my-cheats/arp-failure.json",
)


def _kind_of(subject: str | None, task: str | None, registry: "Registry") -> str:
    """What is audited.

    Raises:
        UsageError: There is nothing of that name.
    """
    name = subject or task
    if name is not None and names_dataset(name):
        return DATASET
    from harness.record import Store
    from harness.registry.choice import kind_of_task, require_known
    from harness.results.recordings.recordings import has_recordings

    if subject is not None and Path(subject).exists():
        folder = Path(subject)
        if folder.is_dir() and Store.is_experiment(folder):
            return ANY_EXPERIMENT
        return RECORDINGS if folder.is_dir() and has_recordings(folder) else LOGS
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


def _search_of(
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
    if kind not in (TASK, ENVIRONMENT):
        return None
    if budget == 0:
        if out or html:
            raise UsageError(f"{'--out' if out else '--html'} needs a search: leave out --budget 0")
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
        budget or usual.budget,
        starts or usual.starts,
        seed,
        tuple(folders or ()),
        tuple(policies or ()),
    )


def _replayed(
    path: Path, sim: str | None, plugin: Sequence[str] | None, measure: Sequence[str] | None, as_json: bool
) -> int:
    """Play a certificate again, and say whether it is paid the same; status 1 if it is not."""
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

    console = Terminal(stderr=True)
    line: Any = SimpleNamespace(
        __rich__=lambda: Text(f"{world.reward}: {world.taken:,} steps of about {asked.budget:,}")
    )
    with console.status(line) if console.is_terminal else nullcontext():  # it is drawn anew
        yield


def _show(found: Sequence[Any], as_json: bool) -> int:
    """Print what was found, and what is wrong, a line each; status 1 where something is."""
    if as_json:
        say_json(found[0].to_json() if len(found) == 1 else [it.to_json() for it in found])
    else:
        from harness.report.tables.grid import show

        for number, it in enumerate(found):
            if number:
                say("")
            show(it)
    wrong = [line for it in found for line in it.wrong]
    for line in wrong:
        complain(line)
    return 1 if wrong else 0
