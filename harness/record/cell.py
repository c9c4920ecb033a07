"""One cell of the matrix: everything that decides what a training run does, how it ended, and how far it is.

What was done in a folder, how it ended, on what machine and with which versions, a ``manifest.json`` says; and whether
the folder, of a cell or of an evaluation elsewhere, still is what was left there.

What a run is doing stands in ``running.json``, for who looks from another process. The file says nothing that lasts: it
is not synced to the disk, and it is gone when the run has ended. A run that was killed leaves it;
`harness.record.store.Store.is_in_use` tells the two apart.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, ClassVar, NamedTuple, Self, TypeVar

from pydantic import Field, with_config

from harness.errors import SchemaError
from harness.eta.manner import OWN_AND_OTHER, Manner
from harness.files.bounded import (
    SUMS,
    digest_of,
    files_in,
    is_partial,
    read_json,
    read_sealed,
    reading,
    seal,
    whole_files,
    write_whole,
)
from harness.files.plain import Plain
from harness.record.earlier import whole_manifest
from harness.record.file_forms import (
    EXACT,
    Chosen,
    Count,
    Digests,
    Environment,
    Line,
    Moment,
    Name,
    Seconds,
    Status,
    Whole,
    read_form,
)
from harness.record.folder import EVALUATIONS, LOG, MANIFEST, POLICY, SCORES, TENSORBOARD, begun_by, digests_in
from harness.registry.choice import Choice


class Place(NamedTuple):
    """What moves in a cell."""

    simulator: Choice
    robot: str


BROUGHT = Place(Choice("(environment)", (), "environment"), "(environment)")
"""The place of a cell in an environment, which brings what moves there: no plugin can have these names."""
UNKNOWN_ALGORITHM = Choice("unknown", (), "unknown")
"""In place of the algorithm of a training that no experiment made: nobody recorded it."""
EVALUATION_HORIZON = 10_000
"""Environment steps after which an episode of an evaluation in an environment is cut: ten times what most allow."""
DISCOUNT = "gamma"
"""The parameter of an algorithm that people are told beside its name, of a cell in an environment."""
LATER = {"evaluate_every": 0, "deterministic": True, "evaluation_horizon": EVALUATION_HORIZON, "records": []}
"""Fields that the first version did not have. At these values they are left out, and ids stay what they were."""


@with_config(EXACT)
@dataclass(frozen=True)
class Cell(Plain):
    """One training run, to be done or done.

    Attributes:
        simulator: Whose engine moves the arm; that of `BROUGHT` where the task is an environment.
        robot: Registered name or folder of the arm; that of `BROUGHT` where the task is an environment.
        task: What the arm has to do, or an environment that trains; see `is_in_environment`.
        algorithm: What learns.
        reward: What it is paid for.
        seed: Of the starts, the targets and the algorithm. Equal seeds meet equal starts and targets, whatever the
            reward or the algorithm.
        steps: Environment steps of training.
        evaluation_episodes: Episodes of an evaluation; the same starts and targets in every cell.
        evaluate_every: Environment steps from one evaluation during training to the next; 0 for one at the end alone.
        deterministic: Whether evaluated policies take the one action of each observation, NOTE eq. 36, or draw.
        evaluation_horizon: In an environment: environment steps after which an episode of an evaluation is cut. A task
            of an arm has a horizon of its own.
        records: What its traces keep beside the usual columns, ``qvel``, because a reward or a measure of the
            experiment reads it; in an environment of an arm, its rewards that the experiment compares. It changes
            nothing of the training, and cells that differ in it alone are the same.
    """

    simulator: Chosen
    robot: Name
    task: Chosen
    algorithm: Chosen
    reward: Chosen
    seed: Whole
    steps: Count
    evaluation_episodes: Count
    evaluate_every: Whole = 0
    deterministic: bool = True
    evaluation_horizon: Count = EVALUATION_HORIZON
    records: Annotated[tuple[Name, ...], Field(max_length=1_000)] = field(default=(), compare=False)

    @cached_property
    def id(self) -> str:
        """A hash of the content, but for `records`."""
        content = {key: value for key, value in self.to_json().items() if key != "records"}
        text = json.dumps(content, sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    @property
    def is_in_environment(self) -> bool:
        """Whether the task is a `harness.environment.Environment`, and the reward one of those that it names."""
        return self.simulator == BROUGHT.simulator

    @property
    def place(self) -> Choice:
        """Where it trains, for people: the simulator, or the environment."""
        return self.task if self.is_in_environment else self.simulator

    @property
    def floor(self) -> tuple[Any, ...]:
        """All that decides what random actions do in an evaluation, but for what they are paid."""
        return self.simulator, self.robot, self.task, self.evaluation_episodes, self.evaluation_horizon

    @property
    def acted(self) -> Manner:
        """How evaluated policies act."""
        return OWN_AND_OTHER[self.deterministic][0]

    @property
    def cut_after(self) -> int | None:
        """Steps after which an episode of an evaluation is cut; None where the task has a horizon of its own."""
        return self.evaluation_horizon if self.is_in_environment else None

    @property
    def learner(self) -> str:
        """For people: the algorithm; in an environment with its discount, though that may be a default."""
        return self.algorithm.label_with(DISCOUNT) if self.is_in_environment else self.algorithm.label

    @property
    def title(self) -> str:
        """For people: the combination and the seed."""
        return f"{self.place.label} · {self.learner} · {self.reward.label} · seed {self.seed}"

    @property
    def plugins(self) -> dict[str, str]:
        """Names of the plugins that it chooses, by kind, as manifests name their sources; a robot may be a path."""
        if self.is_in_environment:
            return {"environments": self.task.name, "algorithms": self.algorithm.name}
        return {
            "simulators": self.simulator.name,
            "tasks": self.task.name,
            "algorithms": self.algorithm.name,
            "rewards": self.reward.name,
            "robots": self.robot,
        }

    @property
    def drives_with_servo(self) -> bool:
        """Whether the drives of the robot's robot.toml move the arm: their numbers decide the result then."""
        return self.simulator.named.get("drive") == "servo"

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same cell back."""
        return {key: value for key, value in super().to_json().items() if not (key in LATER and value == LATER[key])}


SEALED_SINCE = 2
"""The first format of manifests, those of added folders included, that names the digests of its folder's files."""
SHOWN_DIGITS = 8
"""The digits of a hash of sources, where people read it."""
OF_A_GOAL = ("error", "unit")
"""Left out of the file where the task has none: it is as it was before there were any."""
Record = TypeVar("Record", bound="Ending")
REMEDY = "run again to replace it"
NO_RECORDINGS = (".", EVALUATIONS, POLICY)
"""Folders of a cell, its own included, whose files are no recording."""
PAID_LATER = "scores"
"""What the names of files begin with that `harness score` adds to a cell."""
KERNEL = "kernel of OpenBLAS"
"""What people read for what `harness.experiment.provenance.blas_kernel` tells."""


@with_config(EXACT)
@dataclass(frozen=True, kw_only=True)
class Ending(Plain):
    """How the work for one folder ended.

    Attributes:
        status: ``done``, ``failed``, ``skipped``, ``pending``, ``damaged`` or, where the answer stands without it,
            ``not needed``; the last three are never written.
        reason: Why it is not done; empty if it is.
        started: UTC, ISO 8601.
        seconds: Wall time of all of it, [s].
        environment: Versions, machine, engine, commit, command, hashes of the sources; see
            `harness.experiment.provenance.describe_environment`.
        files: SHA-256 of every other file in the folder, by its path there.
    """

    status: Status
    reason: Line = ""
    started: Moment = ""
    seconds: Seconds = 0.0
    environment: Environment = field(default_factory=dict)
    files: Digests = field(default_factory=dict)

    FORMAT: ClassVar[int]

    def write(self, folder: Path) -> Self:
        """Write ``manifest.json`` into `folder`, which is not complete yet, with the digest of every file there.

        Returns:
            What was written: the record with those digests.
        """
        record = replace(self, files=digests_in(folder))
        write_whole(folder / MANIFEST, seal({"format": self.FORMAT, **record.to_json()}))
        return record


@with_config(EXACT)
@dataclass(frozen=True)
class Manifest(Ending):
    """The record of one cell.

    Attributes:
        cell: What was run.
        training_seconds: Of the training alone, up to the checkpoint it was resumed from included, [s].
        resumed_from: Environment steps that an earlier process, which was killed, left in a checkpoint; 0 if none did.
        note: What there is to know of it: where the training went on after such a process, or why it started over. In
            an environment also that no episode ended, how many episodes of the evaluation were cut, and which rewards
            and measures failed while they looked on.
        peak_memory: The most that the cell's process had in memory at once, in bytes; 0 if it is not known.
        error: What the task calls the distance that it measures, as ``pose error``; empty if that is the distance from
            end effector to target, in metres.
        unit: Of the error.
    """

    cell: Cell
    training_seconds: Seconds = 0.0
    resumed_from: Whole = 0
    note: Line = ""
    peak_memory: Whole = 0
    error: Line = ""
    unit: Line = ""

    FORMAT: ClassVar[int] = 2

    def to_json(self) -> dict[str, Any]:
        """Plain data; the cell's id stands beside it, for who looks for it."""
        told = {"id": self.cell.id, **super().to_json()}
        return told if self.error else {name: value for name, value in told.items() if name not in OF_A_GOAL}


def read_manifest(folder: Path) -> Manifest:
    """The manifest in a cell's folder.

    Raises:
        SchemaError: It is damaged or written by a newer version.
    """
    return read_record(folder, Manifest, "manifest")


def read_record(folder: Path, kind: type[Record], noun: str) -> Record:
    """What the ``manifest.json`` in `folder` tells.

    Args:
        folder: Of a cell, or one that a command added.
        kind: Of the record. The annotations of its fields say what may stand in the file.
        noun: What the file should be, for the message if it is not.

    Raises:
        SchemaError: The file is damaged, or written by a newer version.
    """
    path = folder / MANIFEST
    data = read_sealed(path, noun, kind.FORMAT, SEALED_SINCE)
    with reading(path, noun):
        if "files" not in data and data.get("format", 1) < SEALED_SINCE:
            data = whole_manifest(data, folder)
        if not {"format", "files"} <= data.keys():
            raise ValueError("it tells no format, or no digests of files")
        told = {name: it for name, it in data.items() if name not in ("format", "id")}
        return read_form(kind, told)


def now() -> str:
    """The time in UTC, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def write_log(path: Path, text: str) -> None:
    """Append a line with the time, UTC."""
    with path.open("a", encoding="utf-8") as log:
        log.write(f"{now()} harness: {text}\n")


def whole_cell(folder: Path) -> Manifest:
    """The manifest of the cell whose folder this is, by its name, if every file is what the cell left.

    Raises:
        SchemaError: It is not.
        NewerFormat: A newer version made the cell.
    """
    try:
        if folder.is_symlink() or not folder.is_dir():
            raise SchemaError(f"{folder} is no folder")
        manifest = read_manifest(folder)
        if manifest.cell.id != folder.name:
            raise SchemaError(f"{folder} holds another cell, {manifest.cell.id}")
        require_files(folder, manifest)
        # A reader takes all that lies in the folder of a recording, and all parts of a trace.
        recordings = {PurePosixPath(name).parent for name in manifest.files} - {*map(PurePosixPath, NO_RECORDINGS)}
        for name in added_files(folder, manifest):
            if PurePosixPath(name).parent in recordings or begun_by(name) in manifest.files:
                raise SchemaError(f"{folder / name} was added to what was recorded")
    except OSError as error:
        raise SchemaError(f"{folder} cannot be read: {error.strerror}") from error
    return manifest


def require_files(folder: Path, record: Ending) -> None:
    """See whether the files in `folder` are those that its record names.

    Raises:
        SchemaError: One is not what was written, or is missing and no report can do without it; the message names it.
    """
    for name, digest in record.files.items():
        path = folder / name
        if path.is_symlink():
            raise SchemaError(f"{path} is a link")
        if not path.is_file():
            if is_needed(name):
                raise SchemaError(f"{path} is missing")
            continue
        try:
            found = digest_of(path)
        except OSError as error:
            raise SchemaError(f"{path} cannot be read: {error.strerror}") from error
        if found != digest:
            raise SchemaError(f"{path} is not what was written: its SHA-256 differs")


def is_named(record: Ending, name: str) -> bool:
    """Whether a record names a file, or files of a folder."""
    return name in record.files or any(known.startswith(f"{name}/") for known in record.files)


def added_files(folder: Path, record: Ending) -> list[str]:
    """Files in `folder` that its record does not name, nor a command of the harness adds. No report reads them."""
    there = [path for path in files_in(folder) if path.name not in (MANIFEST, SUMS) and not is_partial(path)]
    names = [path.relative_to(folder).as_posix() for path in there if not path.name.startswith(PAID_LATER)]
    return [name for name in names if name not in record.files]


def is_needed(name: str) -> bool:
    """Whether reports read this file of a cell; others may be taken away, to make a folder smaller."""
    return PurePosixPath(name).parts[0] not in (POLICY, TENSORBOARD, LOG, SCORES)


RUNNING = "running.json"


@dataclass(frozen=True)
class Running:
    """A cell that is being done; times are seconds since 1970.

    Attributes:
        started: When it began.
        steps: Environment steps done.
        told: When it told so.
        track: When it was begun that trackers follow, as they were told: earlier than `started` of a cell that goes on
            after a kill. 0 before trackers know of it.
        tracked: Environment steps of which trackers were told.
    """

    started: Seconds
    steps: Whole = 0
    told: Seconds = 0.0
    track: Seconds = 0.0
    tracked: Whole = 0

    def after(self, steps: int, now: float) -> Self:
        """The same cell, when it has told its steps."""
        return replace(self, steps=max(steps, self.steps), told=now)


def write_running(folder: Path, running: Mapping[str, Running]) -> None:
    """Write down the running cells of the experiment in `folder`, by id."""
    content = json.dumps({cell: asdict(one) for cell, one in running.items()})
    with whole_files(folder, [RUNNING], is_lasting=False) as (partial,):
        partial.write_text(content)


def read_running(folder: Path) -> dict[str, Running]:
    """The cells of the experiment in `folder` that a run is doing, or was when it was killed, by id.

    Raises:
        SchemaError: The file is damaged.
    """
    path = folder / RUNNING
    if not path.exists():
        return {}
    with reading(path, "account of running cells"):
        return read_form(dict[str, Running], read_json(path))


def read_left(folder: Path) -> dict[str, Running]:
    """The same, for the run that begins after a kill: where the file is damaged, nothing is known."""
    try:
        return read_running(folder)
    except SchemaError:
        return {}
