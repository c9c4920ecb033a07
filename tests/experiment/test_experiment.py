"""From the plan to the results."""

from dataclasses import replace
from pathlib import Path

import pytest

import harness
from harness import load_results, run
from harness.executor import Event, Limits
from harness.experiment.experiment import ExperimentRun, check, default_folder
from harness.experiment.plan import check_experiment, expand
from harness.experiment.run_options import RunOptions
from harness.record import LOG, Manifest, Store, partial_folder
from harness.registry import Choice
from harness.results import Results
from tests.left import files_of
from tests.refusals import refused
from tests.stores import create_store

QUICK = {
    "sim": "ideal",
    "algo": "wander",
    "reward": "arp",
    "seeds": 1,
    "steps": 6,
    "evaluation_episodes": 2,
}
TASK = "fd100-reach:horizon=5"


def _plan(registry, **keys):
    return expand(check_experiment({**QUICK, "task": TASK, "seeds": 2, **keys}), registry)


def _events(toys, folder, plan, **options):
    """The ends of cells in a run of the plan, in this process."""
    events, executor = [], toys.get("executors", "here").load()()
    ExperimentRun(plan, Store.claim(folder), toys, executor, RunOptions(**options)).run(events.append)
    return [event for event in events if event.kind == "ended"]


def _ended(toys, folder, plan):
    return [event.cell for event in _events(toys, folder, plan)]


def test_run_does_every_cell_and_returns_the_results(toys, tmp_path):
    """From names to results, in worker processes; one name need not stand in a list."""
    results = run(out=tmp_path / "out", jobs=2, task=TASK, **QUICK)
    assert isinstance(results, Results)
    assert [(item.cell.reward.label, item.status) for item in results.manifests] == [
        ("baseline", "done"),
        ("arp", "done"),
    ]
    assert [item.seeds for item in results.combinations] == [(0,)]


def test_failed_cells_cost_themselves_alone(toys, tmp_path):
    """One that raises and one that is killed are failed, each with its reason and its log; the others are done."""
    algorithms = ["wander", {"name": "wander", "then": "raise"}, {"name": "wander", "then": "die silently"}]
    results = run(out=tmp_path / "out", jobs=2, task=TASK, **{**QUICK, "algo": algorithms})
    by_algorithm = {manifest.cell.algorithm.label: manifest for manifest in results.manifests}
    assert {label: manifest.status for label, manifest in by_algorithm.items()} == {
        "wander": "done",
        "wander:then=raise": "failed",
        "wander:then=die silently": "failed",
    }
    assert by_algorithm["wander:then=raise"].reason == "RuntimeError: the arm fell off"
    killed = by_algorithm["wander:then=die silently"]
    assert killed.reason == "its process ended with exit status 0 before the cell did"
    assert (results.store.cell_folder(killed.cell) / LOG).read_text().endswith("last words\n")
    assert len(results.failed) == 4


def test_end_of_a_failed_cell_tells_why(toys, tmp_path):
    """Who follows a run hears the reason that the manifest has, and of a done cell none."""
    plan = _plan(toys, algo=["wander", "wander:then=raise"], seeds=1)
    told = {(event.cell.algorithm.label, event.reason) for event in _events(toys, tmp_path, plan)}
    assert told == {("wander", ""), ("wander:then=raise", "RuntimeError: the arm fell off")}


def test_second_run_does_only_what_is_not_done(toys, tmp_path):
    """Done cells stay as they are; a failed cell and new ones are run."""
    plan, more = _plan(toys), _plan(toys, seeds=3)
    assert _ended(toys, tmp_path, plan) == list(plan.cells)
    assert _ended(toys, tmp_path, plan) == []
    store, failed = Store(tmp_path), plan.cells[1]
    Manifest(failed, status="failed", reason="no luck").write(store.cell_folder(failed))
    assert _ended(toys, tmp_path, more) == [failed, *more.cells[4:]]
    assert store.examine(failed).status == "done"


def test_skipped_cells_are_not_run(toys, tmp_path):
    """A combination that cannot work is recorded, and no executor sees it."""
    plan = _plan(toys, algo=["buttons", "wander"], task="handless", seeds=1)
    assert {cell.algorithm.label for cell in _ended(toys, tmp_path, plan)} == {"wander"}
    assert {item.status for item in load_results(tmp_path, registry=toys).manifests} == {"done", "skipped"}


def test_reason_of_a_cell_without_a_folder_is_recorded(toys, make_cell, tmp_path):
    """What an executor says of a cell that it lost becomes the cell's manifest."""

    class Losing:
        def run(self, jobs, at_once, on_event):
            for job in jobs:
                on_event(Event("ended", job.cell, reason="lost on the way"))

    plan = _plan(toys, seeds=1)
    store = create_store(tmp_path, plan)
    ExperimentRun(plan, store, toys, Losing()).run()
    assert [(item.status, item.reason) for item in store.manifests()] == [("failed", "lost on the way")] * 2


def test_interrupt_keeps_what_is_finished(toys, tmp_path):
    """KeyboardInterrupt passes; done cells are done, and nothing half-done is left or locked."""
    plan = _plan(toys, algo=["wander", "wander:then=interrupt"], seeds=1)
    first, *_ = (cell for cell in plan.cells if cell.algorithm.label == "wander")
    bad = next(cell for cell in plan.cells if cell.algorithm.label != "wander")
    plan = replace(plan, cells=(first, bad))
    store = create_store(tmp_path, plan)
    with pytest.raises(KeyboardInterrupt):
        _ended(toys, tmp_path, plan)
    assert [manifest.cell for manifest in store.manifests()] == [first]
    assert not partial_folder(store.cell_folder(bad)).exists()
    with store.locked():
        assert store.examine(first).status == "done"


def test_folder_in_use_is_refused(toys, tmp_path):
    """Two runs do not meet in one folder."""
    plan = _plan(toys)
    store = create_store(tmp_path, plan)
    before = files_of(tmp_path)
    second = ExperimentRun(plan, store, toys, toys.get("executors", "here").load()(), RunOptions(wait=False))
    with store.locked(), refused("Another run is using"):
        second.run()
    assert files_of(tmp_path) == before


REFUSED = {
    "name": ({"sim": "idael"}, "No simulator 'idael'"),
    "steps": ({"steps": 0}, "Experiment: steps=0: Input should be greater than 0"),
    "no jobs": ({"jobs": 0}, "jobs=0: must be at least 1"),
    "fewer jobs": ({"jobs": -1}, "jobs=-1: must be at least 1"),
    "key": ({"stpes": 3}, "Experiment has no parameter 'stpes'"),
    "a key of a table": ({"sim": {"name": "ideal", "dt": 1}}, "Simulator 'ideal' has no parameter 'dt'"),
    "a setting of an executor": ({"executor": "processes:x=1"}, "Executor 'processes' has no parameter 'x'"),
    "a cell": ({"only": "nobody"}, ".*no cell of this experiment has 'nobody'"),
    "what can run": ({"task": "fd100-reach:action=discrete"}, "Nothing can be run: .*wander"),
}


@pytest.mark.parametrize(("keys", "message"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_used_writes_nothing(toys, tmp_path, keys, message):
    """A usage error comes before the folder does."""
    with refused(f"^{message}") as told:
        run(out=tmp_path / "out", **{**QUICK, **keys})
    assert str(told.value).count("wander") <= 1, "a reason is said once"
    assert not list(tmp_path.iterdir())


def test_default_folder_is_named_for_the_plan(toys):
    """The same plan finds its results again; another plan has another folder."""
    plan = _plan(toys)
    assert default_folder(plan) == Path("results/runs") / f"ideal-wander-{plan.id}"
    assert default_folder(_plan(toys, reward=["arp:k2=1.50"])) == default_folder(plan)
    assert default_folder(_plan(toys, steps=18)) != default_folder(plan)


def test_plan_of_skipped_cells_alone_has_a_folder(make_cell, make_plan):
    """Where nothing can be run there is still a place to say why."""
    odd = make_cell(algorithm=Choice("buttons", (), "buttons"))
    assert default_folder(make_plan(skipped=((odd, "no"),))).name.startswith("ideal-buttons-")


def test_run_is_public(toys):
    """`harness.run` is this function."""
    assert harness.run is run


def test_executor_is_given_with_its_settings(toys, tmp_path):
    """As text or as a table; its fields are its settings."""
    for number, executor in enumerate(["here", "here:note=x", {"name": "here", "note": "y"}]):
        assert not run(out=tmp_path / str(number), task=TASK, executor=executor, **QUICK).failed
    assert (tmp_path / "0").is_dir()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"jobs": 0}, "jobs=0: must be at least 1"),
        ({"checkpoint_every": -1}, "checkpoint_every=-1: must be a number above 0, or 0 for none"),
        ({"stall_after": float("nan")}, "stall_after=nan: must be a number above 0, or 0 for never"),
        ({"cell_memory": -0.5}, "cell_memory=-0.5: must be a number above 0, or 0 for no limit"),
        ({"limit": 0}, "limit=0: must be at least 1"),
        ({"curve": "steep"}, "curve='steep': allowed are accumulated and per-step"),
    ],
)
def test_options_out_of_range_are_refused(options, message):
    """However they were given."""
    with refused(message):
        RunOptions(**options)


def _done(toys, folder, plan, **options):
    """Label of the algorithm and status of each cell that a run with these options started, in order."""
    return [
        (event.cell.algorithm.label, "failed" if event.reason else "done")
        for event in _events(toys, folder, plan, **options)
    ]


BREAKS = {"name": "wander", "then": "raise"}


def test_a_limit_leaves_the_other_cells_for_later(toys, tmp_path):
    """The next run goes on with them."""
    plan = _plan(toys)
    assert len(_done(toys, tmp_path / "out", plan, limit=3)) == 3
    assert len(_done(toys, tmp_path / "out", plan)) == 1


def test_only_some_cells(toys, tmp_path):
    """Those that are named; the plan holds all."""
    plan = _plan(toys)
    assert len(_done(toys, tmp_path / "out", plan, only="arp")) == 2
    results = harness.load_results(tmp_path / "out")
    assert sorted(manifest.status for manifest in results.manifests) == ["done", "done", "pending", "pending"]


def test_failed_cells_are_tried_again(toys, tmp_path):
    """After all others, as often as asked for, and no done one."""
    plan = _plan(toys, algo=["wander", BREAKS], seeds=1, reward=[])
    assert _done(toys, tmp_path / "out", plan, retry_failed=2) == [
        ("wander", "done"),
        ("wander:then=raise", "failed"),
        ("wander:then=raise", "failed"),
        ("wander:then=raise", "failed"),
    ]


def test_a_failure_may_end_the_run(toys, tmp_path):
    """What comes after it stays pending."""
    plan = _plan(toys, algo=[BREAKS, "wander"], seeds=1, reward=[])
    assert _done(toys, tmp_path / "out", plan, fail_fast=True) == [("wander:then=raise", "failed")]


def test_limits_reach_the_cells():
    """Every executor finds them in the job."""
    options = RunOptions(stall_after=5.0, cell_time=60.0, cell_memory=2.0, fresh=True).of_cells
    assert options.limits == Limits(5.0, 60.0, 2.0)
    assert options.fresh


def test_cells_of_0_2_stay_beside_those_of_the_quick_learner(toys, tmp_path):
    """Where they are called `sac`, which means another algorithm now; one line says so, of such folders alone."""
    plan = _plan(toys, sim=["kinematic"], algo=["sac"], seeds=1)
    old = Choice("sac", plan.cells[0].algorithm.params, "sac")
    cells = tuple(replace(cell, algorithm=old) for cell in plan.cells)
    Store.claim(tmp_path / "old")
    Store.at(tmp_path / "old").add(replace(plan, cells=cells))
    asked = check_experiment(
        {**QUICK, "sim": ["kinematic"], "algo": [{"name": "sac", **dict(old.params)}], "task": TASK}
    )
    ready = check(asked, RunOptions(out=tmp_path / "old"))
    assert {cell.algorithm.label for cell in ready.plan.cells} == {"sac-fast"}
    assert not {cell.id for cell in ready.plan.cells} & {cell.id for cell in cells}
    (told,) = ready.plan.warnings
    assert told.startswith(
        "until 0.2 'sac' was the algorithm that is called sb3-sac now; since 0.3 it is short for sac-f"
    )
    assert not check(asked, RunOptions(out=tmp_path / "new")).plan.warnings
