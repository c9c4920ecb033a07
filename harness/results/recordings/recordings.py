"""The recorded trainings of an experiment's cells in environments, or recordings and logs that lie loose.

They are read, and what makes them one study is found out, with what to keep in mind of it.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from itertools import combinations
from pathlib import Path
from types import MappingProxyType

from harness.arrays import Float
from harness.errors import SchemaError, UsageError
from harness.eta.equal import equal_sentences, equal_trainings
from harness.eta.index import Estimate, mean_of_known
from harness.eta.laws import Account, Missing, counted, numbered, require_direction, shortfall_beside
from harness.eta.manner import ACTED_AT_RANDOM, DETERMINISTIC, MANNERS, OWN_AND_OTHER
from harness.log.measure import Measure
from harness.record.cell import BROUGHT, EVALUATION_HORIZON, UNKNOWN_ALGORITHM, Cell, Manifest, is_named
from harness.record.folder import EVALUATION_RECORDING, RANDOM_RECORDING, TRAINING_RECORDING
from harness.record.plan_file import PLAN, StoredPlan
from harness.record.recording.facts import FILE_BEHAVIOUR, OWN_SOURCE
from harness.record.recording.recorded_training import read_facts, recordings_in
from harness.record.store import MOST_NAMED, floors_in
from harness.registry.choice import Choice, split_list
from harness.results.comparison import Group
from harness.results.frames import Frames, read_frames
from harness.results.logs.told import FOUND_OUT, Told
from harness.results.metrics import require_measures
from harness.results.recordings.episodes import Part, count_text, cut_notes, cut_text, unended_text
from harness.results.recordings.recording_results import RecordingResults
from harness.results.recordings.runs import (
    DIRECTION,
    NO_NAME,
    Run,
    Runs,
    brought,
    called_alike,
    meet_same_starts,
    quantities_of,
    require_one,
    rescaling_between,
)
from harness.results.results import Results, ReturnMatrix
from harness.results.table import Numbers
from harness.results.trainings import Trainings
from harness.score.weights import name_of
from harness.text import command_text

UNLIKE_STARTS = (
    "The policies did not meet the same starts: the first observations of their evaluations differ, so that luck with "
    "the starts is part of every difference. An env has to draw everything random from the generator that reset(seed) "
    "seeds, and every evaluation has to begin with the same seed"
)
GOES_ON = "it is still going on, or was killed"
NO_SEED = "recorded without a seed: numbered in the order of their folders"


def _notes_of(runs: Sequence[Run], everything: Sequence[Run], rewards: Sequence[str]) -> Iterator[str]:
    """What to keep in mind of trainings that are compared, and of everything that was recorded beside them."""
    lengths = cut_notes({f"'{run.path}'": run.steps for run in runs})
    yield from lengths
    if lengths and any(run.evaluation for run in runs):
        yield "Evaluations are of policies at the end of their trainings, which were not of one length"
    if not meet_same_starts(runs):
        yield UNLIKE_STARTS
    for reward in rewards:
        yield from _end_notes(reward, [run for run in runs if run.reward == reward])
    yield from _code_notes(everything)
    left = {
        name: f"{low:g} to {high:g}, in '{it.path}'"
        for it in everything
        for name, (low, high) in it.facts.bounds.items()
        if not it.episodes.is_within(name, (low, high))
    }
    yield from (f"{name} leaves its bounds, {of}: its intervals are not cut to them" for name, of in left.items())
    yield from equal_sentences(equal_trainings({run.key: run.likeness.digest for run in runs}))
    rescaled = dict[str, str]()  # of each reward the first one before it that it is but for scale and offset
    for other, name in combinations(rewards, 2):
        rescaling = rescaling_between(runs, name, other)
        if rescaling is not None:
            rescaled.setdefault(name, rescaling.sentence(name, other))
    yield from rescaled.values()
    yield from (f"{run.path}: {run.facts.paid_otherwise}" for run in runs if run.facts.paid_otherwise)
    told = dict[str, str]()  # once, though every recording may say it with its step
    for run in everything:
        for line in run.facts.notes:
            told.setdefault(line.partition(",")[0], f"{run.path}: {line}")
    yield from told.values()


def _end_notes(reward: str, runs: Sequence[Run]) -> Iterator[str]:
    """Trainings by a reward in which no episode ended, and evaluations whose episodes were cut."""
    unended = [run for run in runs if not len(run.episodes.last)]
    if unended:
        told = f"No episode ended in {len(unended)} of {count_text(len(runs), 'training')} by {reward}"
        yield f"{told}: {unended_text(unended[0].facts, unended[0].steps / unended[0].facts.num_envs)}"
    evaluated = [run.evaluation for run in runs if run.evaluation]
    for horizon in dict.fromkeys(it.facts.horizon for it in evaluated):
        some = [it for it in evaluated if it.facts.horizon == horizon]
        cut = sum(it.facts.cut for it in some)
        if cut:
            told = cut_text(cut, sum(len(it.episodes.last) for it in some), horizon)
            yield f"Policies trained by {reward}: {told}"


def _code_notes(runs: Iterable[Run]) -> Iterator[str]:
    """Rewards and measures that have one name and are not the same."""
    found: dict[str, dict[str, Path]] = {}
    for run in runs:
        for column, source in run.facts.sources.items():
            if source.text and source.text != OWN_SOURCE:
                found.setdefault(column, {}).setdefault(source.text, run.path)
    for column, of in found.items():
        one, *others = of.values()
        if others:
            yield (
                f"The code of {column.replace('/', ' ', 1)} is not the same in '{one}' and '{others[0]}': its numbers "
                "may not be comparable"
            )


def has_recordings(folder: Path) -> bool:
    """Whether a recorded training lies somewhere in a folder."""
    return next(recordings_in(folder), None) is not None


def read_runs(
    folder: Path,
    only: Sequence[Path] | None = None,
    deciding: Sequence[str] = (),
    group: Group | None = None,
    random: Path | None = None,
    control: Mapping[int, int] = MappingProxyType({}),
    told: Told = FOUND_OUT,
) -> Runs:
    """All recorded trainings and evaluations in a folder, at any depth, sorted into what is compared and what is not.

    Args:
        folder: Where they lie.
        only: Of these folders in it, and not at any depth; None for all.
        deciding: Measures that come before the others, the one that decides first.
        group: What the trainings share, if they are known to be of one group of cells.
        random: The recording of random actions in the same env, if it lies somewhere else.
        control: By each seed the other seed that the baseline was trained with again, for the null control.
        told: What the user says: the reward that the others are compared with, by default the one that was given first;
            the trainings that are left out; and which values of the measure that decides are better.

    Raises:
        UsageError: There are none, they are of several envs, two have the same reward and seed, or none has all of its
            steps.
    """
    everything, damaged = read_all(folder, only)
    if not everything:
        unread = f" Damaged: {'; '.join(it.why for it in damaged)}" if damaged else ""
        raise UsageError(f"'{folder}' holds no recorded training: harness.RecordRewards makes one.{unread}")
    at_random = _read(folder, random, _weighed([it.path for it in everything])) if random else None
    env, env_notes = env_of(folder, everything) if group is None else (group.task.label, [])
    account, whole, replaced = account_of_runs(everything, damaged, told.leave_out)
    evaluated = [it for it in whole if it.facts.evaluation]
    runs = _by_key([it for it in whole if not it.facts.evaluation])
    unseeded = sum(it.facts.seed is None for it in runs.values())
    seed_notes = [f"{count_text(unseeded, 'training')} {NO_SEED}"] if unseeded else []
    runs, evaluation_notes = _with_evaluations(folder, runs, evaluated, group is None or group.deterministic)
    others = {other: seed for seed, other in control.items() if other not in control}
    again = {key for key in runs if key[0] == told.baseline and key[1] in others}
    if not runs.keys() - again:
        why = "".join(f". {line}" for line in account.lines[:MOST_NAMED])
        raise UsageError(f"'{folder}' has nothing to report: no training in it has a step, or all of its steps{why}")
    shortest = min(run.steps for key, run in runs.items() if key not in again)
    at_random = at_random or next((it for it in evaluated if it.facts.acted == ACTED_AT_RANDOM), None)
    members = {key: replace(run, cut=shortest, random=at_random) for key, run in runs.items()}
    apart = {others[key[1]]: members.pop(key) for key in again}
    compared = list(members.values())
    named = dict.fromkeys(name for run in compared for name in run.facts.rewards)
    rewards = sorted(named, key=lambda name: name != told.baseline)  # all others stay in their order
    recorded = list(dict.fromkeys(name for run in compared for name in run.facts.behaviour))
    measures, chosen = dict.fromkeys([*deciding, *recorded]), told.deciding.name
    firsts = [("".join(run.facts.behaviour[:1]), f"'{run.path}'") for run in compared if not deciding]
    require_one(firsts, "The first measure decides, and trainings name several", "--measure NAME says which one does")
    return Runs(
        group or brought(env, UNKNOWN_ALGORITHM, shortest),
        tuple(rewards),
        quantities_of(measures, compared, [run.facts for run in compared], told.deciding),
        members,
        shortest,
        (
            *account.lines,
            *replaced,
            *env_notes,
            *seed_notes,
            *evaluation_notes,
            *_notes_of(compared, everything, rewards),
        ),
        tuple(it.why for it in damaged if it in account.missing),
        apart,
        missing=account.missing,
        offered=tuple(it for it in recorded if it != chosen) if chosen not in ("", *recorded[:1]) else (),
    )


def read_all(folder: Path, only: Sequence[Path] | None = None) -> tuple[list[Run], list[Missing]]:
    """Every recording in a folder, at any depth, evaluations too, by its path; and what could not be read.

    The seed of one that was recorded without is -1. With `only` it reads these folders alone.

    Raises:
        UsageError: Whole experiments lie among them.
    """
    inside = sorted(path.parent for path in folder.rglob(PLAN) if path.parent != folder) if only is None else []
    if inside:  # each has a plan of its own, and perhaps an arm's cells
        named = ", ".join(f"'{path}'" for path in inside[:MOST_NAMED])
        raise UsageError(
            f"'{folder}' holds whole experiments, not only recorded trainings: {named}. "
            "Name an experiment itself, and move recordings that belong to none into a folder of their own"
        )
    runs, damaged = list[Run](), list[Missing]()
    paths = sorted(recordings_in(folder)) if only is None else only
    weighed = _weighed(paths)
    for path in paths:
        try:
            runs.append(_read(folder, path, weighed))
        except SchemaError as error:
            damaged.append(Missing(path, str(error)))
    if only is None:
        homes, rewards = [run.path for run in runs], {run.reward for run in runs}
        lost = called_alike(folder, homes, rewards, [it.path for it in damaged])
        damaged += [Missing(it, f"{it} holds no recording") for it in lost if it.is_dir() and not any(it.iterdir())]
    # Where the env paid the reward that taught, a reward recorded as what the env pays has the name of another one.
    # Where the recorder paid the learner, the env itself pays the same whatever taught.
    paid = {run.key for run in runs if run.facts.pay}
    for number, run in enumerate(runs):
        why = f"recorded as what the env pays, and that was {run.reward} here"
        for name, other in run.likeness.paid_alike if run.key not in paid else ():
            if other == run.reward:
                runs[number] = replace(run, episodes=runs[number].episodes.without(name, why))
    return runs, damaged


def account_of_runs(
    runs: Sequence[Run], damaged: Iterable[Missing] = (), leave_out: Collection[Path] = ()
) -> tuple[Account[Run], list[Run], list[str]]:
    """Which trainings count, then the same with the evaluations that count, then lines on those that others replace.

    A training is missing with its evaluation. One that was repeated with the same seed is no outcome of its own.

    Args:
        runs: Trainings and evaluations.
        damaged: Those that could not be read.
        leave_out: What the user leaves out.

    Raises:
        UsageError: Nothing lies at one of these.
    """
    why = {run: why_short(run) for run in runs}
    untold = [it for it in runs if not (it.facts.evaluation or why[it] or it.facts.asked > 0)]
    why |= shortfall_beside({it: (it.reward, it.steps, len(it.episodes.last)) for it in untold}, "steps")
    short = [run for run in runs if why[run]]
    whole = {_place(run) for run in runs if not why[run]}
    replaced = [run for run in short if _place(run) in whole or run.facts.acted == ACTED_AT_RANDOM]
    begun = [run for run in runs if not (run.facts.evaluation or run in replaced)]
    by_key, by_path = {run.key: run for run in begun}, {run.path: run for run in begun}
    evaluations = [it for it in short if it.facts.evaluation and it not in replaced]
    parts = [(by_key.get(it.key), Missing(it.path, why[it])) for it in evaluations]
    parts += [(by_path.get(it.path.parent), it) for it in damaged]
    for home, part in parts:
        if home is not None:
            why[home] = why[home] or f"its evaluation '{part.path}': {part.why}"
    lone = [(None, *part) for home, part in parts if home is None]
    account = counted([*((run, run.path, why[run]) for run in begun), *lone], leave_out)
    out = by_key.keys() - {run.key for run in account.whole}
    kept = [it for it in runs if it.facts.evaluation and not why[it] and (it.seed < 0 or it.key not in out)]
    lines = [f"'{run.path}' is left out: {why[run]}" for run in replaced]
    return account, [*account.whole, *kept], lines


def why_short(run: Run) -> str:
    """Why a recording is not whole by what it says of itself; empty if it is."""
    facts, episodes = run.facts, len(run.episodes.last)
    ended = "It ended early" if facts.closed else GOES_ON.capitalize()
    if episodes < facts.episodes_asked:
        return f"it has {episodes:,} of {facts.episodes_asked:,} episodes. {ended}"
    if run.steps < facts.asked:
        return f"it has {run.steps:,} of {facts.asked:,} steps. {ended}"
    if not run.steps:
        return "it has no steps"
    return "" if facts.closed or facts.asked or facts.episodes_asked else GOES_ON


def _place(run: Run) -> tuple[object, ...]:
    """What a repetition has in common with the run that it replaces."""
    facts, which = run.facts, run.seed if run.seed >= 0 else run.path
    return facts.evaluation, run.reward, which, facts.after, facts.acted or DETERMINISTIC


def _weighed(paths: Sequence[Path]) -> list[str]:
    """The rewards with weights of their terms that some of the recordings were trained with."""
    found: dict[str, None] = {}
    for path in paths:
        with suppress(SchemaError):  # the next reader says so
            found[read_facts(path).trained_with] = None
    return [label for label in found if name_of(label) != label]


def _read(folder: Path, path: Path, weighed: Sequence[str] = ()) -> Run:
    it = RecordingResults(folder, path, weighed)
    run = Run(it, it.facts, -1 if it.facts.seed is None else it.facts.seed, it.steps, it.episodes, it.likeness)
    it.keep()
    return run


def env_of(folder: Path, runs: Sequence[Run]) -> tuple[str, list[str]]:
    """The id of the one env of all, and notes.

    Raises:
        UsageError: There are several.
    """
    named = [(run.facts.env or NO_NAME, f"'{run.path}'") for run in runs]
    name = require_one(named, f"'{folder}' mixes trainings in several envs", "Name a folder of one env")
    given = {str(run.facts.spec.get("kwargs") or {}) for run in runs}
    return name, [f"The env was made with different arguments: {' and '.join(sorted(given))}"] * (len(given) > 1)


def _by_key(runs: Sequence[Run]) -> dict[tuple[str, int], Run]:
    """By reward and seed; those without a seed are numbered: any pairs do that do not depend on what came out."""
    found: dict[tuple[str, int], Run] = {}
    for run, seed in zip(runs, numbered([(it.reward, it.facts.seed) for it in runs]), strict=True):
        other = found.setdefault((run.reward, seed), replace(run, seed=seed))
        if other.path != run.path:
            raise UsageError(
                f"'{other.path.name}' was trained with {run.reward} and seed {seed} too: "
                f"give each a seed of its own, or leave one out, {command_text('--leave-out', run.path)}"
            )
    return found


def _with_evaluations(
    folder: Path, trainings: Mapping[tuple[str, int], Run], evaluated: Sequence[Run], deterministic: bool
) -> tuple[dict[tuple[str, int], Run], list[str]]:
    """The trainings with what evaluated each; and notes.

    Args:
        folder: Where they lie.
        trainings: By reward and seed.
        evaluated: All evaluations, those of random actions too.
        deterministic: How policies act in the evaluations that decide.
    """
    _, other = OWN_AND_OTHER[deterministic]
    kinds: dict[tuple[int, bool], list[Run]] = {}
    for run in evaluated:
        if run.facts.acted != ACTED_AT_RANDOM:
            is_other = not run.facts.after and run.facts.acted == other
            kinds.setdefault((run.facts.after, is_other), []).append(run)
    early = {kind: _by_key(of) for kind, of in sorted(kinds.items())}
    own, others = early.pop((0, False), {}), early.pop((0, True), {})
    final = {**others, **own}  # where only the other manner was recorded, it decides
    notes = [
        f"'{run.path}' is left out: it evaluates {run.reward} of seed {run.seed}, whose training is not in '{folder}'"
        for key, run in final.items()
        if key not in trainings
    ]
    missing = len(trainings.keys() - final.keys())
    if 0 < missing < len(trainings):
        notes.append(f"{missing} of {count_text(len(trainings), 'training')} have no evaluation beside them")
    found = {
        key: replace(
            run,
            evaluation=final.get(key),
            other=others.get(key) if key in own else None,
            before=tuple(of[key] for of in early.values() if key in of),
        )
        for key, run in trainings.items()
    }
    return found, notes


def read_loose(folder: Path, told: Told = FOUND_OUT) -> Runs:
    """The recorded trainings that lie in a folder which is no experiment's, at any depth; see `read_runs`.

    Raises:
        UsageError: There are none, none that can be compared, or whole experiments lie among them; no training was
            taught by the baseline; or nobody says which values of what decides are better.
    """
    baseline, decides = told.baseline, told.deciding.name
    runs = read_runs(folder, None, [decides] if decides else [], told=told)
    known = {name for run in runs.members.values() for name in run.episodes.behaviour}
    if decides and decides not in known:
        raise UsageError(f"--measure {decides}: the recordings tell {', '.join(sorted(known)) or 'none'}")
    first = next(iter(runs.quantities.values()), None)
    if first and len(runs.trained) > 1:
        require_direction(first.name, first.better, DIRECTION.format(first.name))
    if baseline and baseline not in runs.trained:
        raise UsageError(f"--baseline {baseline}: no training was taught by it. There are: {', '.join(runs.trained)}")
    return runs


RETURN = "return_"
"""What the columns of mean returns begin with."""


class Recordings(Results):
    """What cells in an environment left, or recordings and logs that no experiment made."""

    subject, in_environment = "agent", True
    metrics: Mapping[str, Measure] = MappingProxyType({})

    @property
    def _shown(self) -> Sequence[str] | None:
        """Measures of the environment that were chosen, beside the one that decides; None for all."""
        return None if self._chosen is None else split_list(self._chosen)

    @cached_property
    def read(self) -> dict[Group, tuple[Sequence[Cell], Runs | str]]:
        """The done cells of each group, with what they left; why there is nothing to compare where that is so.

        Raises:
            UsageError: A measure was chosen that no environment has.
        """
        found: dict[Group, tuple[Sequence[Cell], Runs | str]] = (
            {self.loose.group: (self.plan.cells, self.loose)}
            if self.loose
            else {group: (cells, self._runs_of(group, cells)) for group, cells in self.groups.items()}
        )
        known = [runs.measures for _, runs in found.values() if isinstance(runs, Runs)]
        if known and self._shown is not None:
            require_measures(self._shown, {name for names in known for name in names})
        return found

    @property
    def _compared(self) -> list[tuple[Sequence[Cell], Runs]]:
        return [(cells, runs) for cells, runs in self.read.values() if isinstance(runs, Runs)]

    def _trainings(self, runs: Runs) -> Trainings:
        deciding = runs.measures[:1]
        keys = [key for reward in runs.trained for key in sorted(runs.members) if key[0] == reward]
        return Trainings(
            runs.group,
            runs.trained[0],
            {key: runs.members[key] for key in keys},
            tuple(it for it in runs.measures if self._shown is None or it in {*deciding, *runs.offered, *self._shown}),
            runs.measure,
            self.kind,
            deciding,
            deciding,
            next((name for name in deciding if runs.quantities[name].episodes), ""),
            self.plan.terms.averaged,
            runs.control,
            is_alone=len(runs.trained) == 1 and not runs.control,
            read=runs,
        )

    def _runs_of(self, group: Group, cells: list[Cell]) -> Runs | str:
        """The recorded trainings of cells; why there is nothing to compare where that is so."""
        trained, control = {cell.reward.label for cell in cells}, self.plan.control
        planned = {cell.reward.label for of, cell in self._grouped(self.manifests) if of == group}
        is_choosing = bool(self.plan.terms.budget)
        if len(trained) < 2 and not control and planned > trained and not is_choosing:
            return f"nothing to compare: all done cells were trained with {cells[0].reward.label}"
        only = [
            path
            for cell in cells
            for folder in (self.store.cell_folder(cell),)
            for path in sorted(recordings_in(folder))
            if is_named(self.manifest(cell), path.relative_to(folder).as_posix())
        ]
        floor = floors_in(self.manifests, self.store).get(cells[0].floor)
        random = None if floor is None else self.store.cell_folder(floor) / RANDOM_RECORDING
        # Where one of several rewards is chosen, the baseline trains last.
        baseline = self.baseline if self.baseline in trained or not is_choosing else ""
        try:
            return read_runs(self.folder, only, self.named, group, random, control, Told(baseline=baseline))
        except UsageError as error:
            return str(error)

    @cached_property
    def trainings(self) -> list[Trainings]:
        return [self._trainings(runs) for _, runs in self._compared]

    def _lines(self) -> Iterable[str]:
        told: dict[str, None] = {}
        for group, (cells, runs) in self.read.items():
            if isinstance(runs, str):
                noted = (f"{it.title}: {note}" for it in cells if (note := self.manifest(it).note))
                lines, begin = (runs, *noted), f"{group.title}: "
            else:
                lines, begin = runs.notes, f"{group.title}: " * (len(self.read) > 1)
            told |= dict.fromkeys(f"{begin}{line}" for line in lines)
        return told

    def _matrices(self) -> Iterator[ReturnMatrix]:
        """See `Results`; one for each manner."""
        for _, runs in self._compared:
            taught = {
                name: [run.parts(runs.steps) for key, run in sorted(runs.members.items()) if key[0] == name]
                for name in runs.trained
            }
            for manner in MANNERS:
                if any(manner in parts for of in taught.values() for parts in of):
                    rows = {
                        payer: {name: _paid([parts.get(manner) for parts in of], payer) for name, of in taught.items()}
                        for payer in runs.rewards
                    }
                    yield ReturnMatrix(runs.group, tuple(taught), rows, {}, manner)

    def numbers(self, cell: Cell) -> Numbers:
        """See `Results`: means over the episodes of the final policy, else over those that say most about it."""
        if self.loose:
            run = self.runs[cell.id]
            return numbers_of_part(next(iter(run.parts(run.steps).values())))
        return numbers_in_environment(self.folder, self.store.cell_folder(cell))

    def recorded(self, cell: Cell) -> Float:
        if self.loose:
            return self.runs[cell.id].recorded.paid_by(cell.reward.label)
        training = self.store.cell_folder(cell) / TRAINING_RECORDING
        return RecordingResults(self.folder, training).paid_by(cell.reward.label)

    def frames(self, cell: Cell, episode: int = 0) -> Frames:
        if self.loose:
            return Frames("recordings that no experiment made hold no policies, so no episode can be played again")
        return read_frames(self.folder, self.manifest(cell), episode)

    def _examine(self, cell: Cell) -> Manifest:
        return Manifest(cell, status="done") if self.loose else super()._examine(cell)

    def run(self, cell: Cell) -> Run | None:
        return self.runs.get(cell.id)

    @cached_property
    def runs(self) -> dict[str, Run]:
        """The trainings that were read, those of the null control too, by id of the cell."""
        return {
            cell.id: run
            for cells, runs in self._compared
            for of in ({it.key: it for it in (*runs.members.values(), *runs.control.values())},)
            for cell in cells
            if (run := of.get((cell.reward.label, cell.seed)))
        }


def _paid(parts: Sequence[Part | None], payer: str) -> Estimate:
    """What a reward pays an episode of each of some trainings."""
    whys = (part.reasons.get(payer, "not recorded") for part in parts if part and part.returns.get(payer) is None)
    paid = [part.returns.get(payer) if part else None for part in parts]
    return mean_of_known(paid, f"seeds have none: {next(whys, 'not recorded')}")


def plan_of(runs: Runs) -> StoredPlan:
    """A plan of trainings that no experiment made; the reward that was given first is the baseline."""
    group = runs.group
    cells = (
        Cell(
            *BROUGHT, group.task, group.algorithm, Choice(reward, (), reward), seed, group.steps,
            group.evaluation_episodes, evaluation_horizon=EVALUATION_HORIZON,
        )
        for reward, seed in runs.members
    )  # fmt: skip
    return StoredPlan(runs.trained[0], False, {}, tuple(cells), {})


def numbers_in_environment(folder: Path, files: Path) -> Numbers:
    """What the final policy of a cell in an environment did, and what every reward paid for it: means over episodes.

    Args:
        folder: The experiment's.
        files: The cell's.

    Raises:
        SchemaError: The recording of its evaluation is damaged.
    """
    return numbers_of_part(_read(folder, files / EVALUATION_RECORDING).whole)


def numbers_of_part(part: Part) -> Numbers:
    """Measures and mean returns of some episodes, by the columns that they have in a table of cells."""
    did = {f"{FILE_BEHAVIOUR}{name}": value for name, value in part.behaviour.items()}
    return Numbers({**did, **{f"{RETURN}{name}": value for name, value in part.returns.items()}}, part.reasons)
