"""What several tests need: packages that are only for a test, cells and plans to try things on."""

import gc
import os
import shutil
import signal
import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from numpy.random import default_rng

import harness
from harness import load_registry, load_results
from harness.executor import Cell
from harness.experiment.experiment import ExperimentRun
from harness.experiment.plan import Plan
from harness.experiment.workers.workers import News
from harness.files.bounded import note_made
from harness.policy.discrete import ChoosingNetwork
from harness.record import EVALUATION, REPORT, Store
from harness.registry import Choice
from harness_plugins.transfer import TransferRecord, simulator_id

settings.register_profile("no deadline", deadline=None)  # a busy machine is no bug
settings.load_profile("no deadline")


def pytest_collection_finish():
    """Let the garbage collector leave out the tests themselves, torch and so on, which stay: it would take 3 %."""
    gc.freeze()
    gc.set_threshold(100_000, 20, 20)


DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY", "MUJOCO_GL", "PYOPENGL_PLATFORM")
"""Environment variables that say what MuJoCo renders with."""


@pytest.fixture(scope="session", autouse=True)
def interruptible():
    """Let whatever the tests start be interrupted.

    A shell that starts the tests in the background has them ignore SIGINT, and whoever they start.
    """
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session", autouse=True)
def own_state(tmp_path_factory):
    """Whatever the tests start keeps its state apart from the user's, as the key that signs kept results."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        yield


@pytest.fixture(scope="session", autouse=True)
def unsynced(request):
    """Nothing that this process writes waits for the disk: what a stopped machine would lose is lost to no test.

    That files are synced, and in which order, `tests/files` says. Timings do wait, as users do.
    """
    with pytest.MonkeyPatch.context() as patch:
        if request.config.getoption("markexpr") != "bench":
            patch.setattr(os, "fsync", lambda number: None)
        yield


def _run_without_display(code, *, library=None, warnings="default"):
    env = {name: value for name, value in os.environ.items() if name not in DISPLAYS}
    env |= {} if library is None else {"MUJOCO_GL": library}
    command = [sys.executable, "-W", warnings, "-c", code]
    return subprocess.run(command, env=env, capture_output=True, text=True, check=False)


@pytest.fixture(scope="session")
def run_without_display():
    """Run code in a process of its own that has no display, with a `library` as MUJOCO_GL or none."""
    return _run_without_display


@pytest.fixture(scope="session")
def _egl_fault():
    """Why this machine has no EGL, or nothing; found by trying, without the code that is tested."""
    done = _run_without_display("from mujoco.egl import GLContext\nGLContext(8, 8).make_current()", library="egl")
    return "" if done.returncode == 0 else (done.stderr.splitlines() or ["it fails without a word"])[-1]


@pytest.fixture
def egl(_egl_fault, monkeypatch):
    """Frames are drawn by EGL, which needs no display."""
    if _egl_fault:
        pytest.skip(f"EGL does not render here, install libegl1: {_egl_fault}")
    monkeypatch.setenv("MUJOCO_GL", "egl")


@pytest.fixture(scope="session")
def registry():
    """The installed plugins."""
    from tests.registered import REGISTRY

    return REGISTRY


@pytest.fixture
def installed(simulator):
    """Skip the test of a `simulator` whose library is not installed, and say what brings it."""
    spec = load_registry().get("simulators", simulator)
    if spec.missing:
        pytest.skip(f"{', '.join(spec.missing)} is not installed: {spec.remedy}")


@pytest.fixture(scope="session")
def toy_folder(tmp_path_factory):
    """A folder with the package `toy_arm` and its metadata, as an installer leaves them."""
    folder = tmp_path_factory.mktemp("site-packages")
    shutil.copy(Path(__file__).parent / "toy_arm.py", folder)
    _write_metadata(folder, "toy-arm", "toys", "toy_arm")
    return folder


def _write_metadata(folder, distribution, entry, module):
    metadata = folder / f"{distribution.replace('-', '_')}-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(f"[harness]\n{entry} = {module}\n")


@pytest.fixture
def toys(toy_folder, monkeypatch):
    """All plugins, `toy_arm` included, which is installed for this process and for those that it starts."""
    monkeypatch.syspath_prepend(toy_folder)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [str(toy_folder), os.environ.get("PYTHONPATH")])))
    monkeypatch.delenv("HARNESS_PLUGINS", raising=False)
    return load_registry()


@pytest.fixture
def recorded(toys, tmp_path, tmp_path_factory):
    """A copy of a finished experiment: an ideal arm that acts at random under two rewards; it runs once."""
    kept = tmp_path_factory.getbasetemp() / "recorded"
    if not kept.exists():
        settings = {
            "sim": "ideal",
            "algo": "wander",
            "reward": "arp",
            "seeds": 1,
            "steps": 12,
            "evaluation_episodes": 4,
        }
        harness.run(**settings, executor="here", out=tmp_path / "new")
        (tmp_path / "new").rename(kept)
    return load_results(shutil.copytree(kept, tmp_path / "recorded"))


@pytest.fixture
def write_plugin(tmp_path, monkeypatch):
    """Write a module that can be imported, and get the entry point that names it."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delenv("HARNESS_PLUGINS", raising=False)

    def write(source, name, entry=""):
        module = f"{name}_{tmp_path.name}".replace("-", "_")  # another test's module of the same name is still imported
        (tmp_path / f"{module}.py").write_text(source)
        return EntryPoint(entry or name, module, "harness")

    return write


@pytest.fixture
def install(tmp_path_factory, monkeypatch):
    """Install a package for this process: a module with hooks, others beside it; gives the name of the module."""

    def install_package(name, hooks, **others):
        folder = tmp_path_factory.mktemp("site-packages")
        module = f"{name}_{folder.name}".replace("-", "_")  # another test's module of the same name is still imported
        (folder / f"{module}.py").write_text(hooks)
        for other, source in others.items():
            (folder / f"{module}_{other}.py").write_text(source)
        _write_metadata(folder, name, name, module)
        monkeypatch.syspath_prepend(folder)
        return module

    return install_package


@pytest.fixture
def distant(install):
    """A package whose simulator `distant` takes a library that is not installed, and names the extra that brings it."""
    install(
        "far-away",
        "import harness\n@harness.hookimpl\ndef register_simulators(register):\n"
        "    register('distant', 'a:B', summary='not here', requires=['no_such_engine'], extra='engine')\n",
    )


@pytest.fixture
def make_cell():
    """A cell that the ideal arm does in a moment; some fields may be said otherwise."""

    def make(**fields):
        given = {
            "simulator": Choice("ideal", (), "ideal"),
            "robot": "fd100",
            "task": Choice("fd100-reach", (("horizon", 5),), "fd100-reach:horizon=5"),
            "algorithm": Choice("wander", (), "wander"),
            "reward": Choice("baseline", (), "baseline"),
            "seed": 0,
            "steps": 12,
            "evaluation_episodes": 2,
        }
        return Cell(**{**given, **fields})

    return make


@pytest.fixture
def read_events():
    """The scalars in a folder's event files, as TensorBoard reads them: by name, (steps, value) in order."""

    def read(folder):
        from tensorboard.backend.event_processing.event_file_loader import EventFileLoader
        from tensorboard.util.tensor_util import make_ndarray

        found = {}
        for path in sorted(folder.iterdir()):
            for event in EventFileLoader(str(path)).Load():
                for value in event.summary.value:
                    found.setdefault(value.tag, []).append((event.step, make_ndarray(value.tensor).item()))
        return found

    return read


@pytest.fixture
def make_plan():
    """A plan of given cells."""

    def make(
        *cells,
        skipped=(),
        baseline="baseline",
        control=None,
    ):
        return Plan(baseline, cells, skipped, {"sim": ["ideal"], "algo": ["wander"]}, control or {})

    return make


@pytest.fixture
def run_here(toys):
    """Run a plan in this process, which is quicker than in workers; gives what its folder says afterwards."""

    def run(plan, folder, on_event=lambda event: None):
        executor = toys.get("executors", "here").load()()
        return ExperimentRun(plan, Store.claim(folder), toys, executor).run(on_event)

    return run


@pytest.fixture
def run_once(toys, run_here, tmp_path_factory):
    """As `run_here`, into a new folder; a plan that another test ran before is not run again: its folder is copied."""

    def run(plan, folder):
        kept = tmp_path_factory.getbasetemp() / "ran once" / plan.id
        if not kept.exists():
            making = kept.with_name("making")
            run_here(plan, making)
            making.rename(kept)
        shutil.copytree(kept, folder)
        return load_results(folder, registry=toys)

    return run


@pytest.fixture
def transferred_here(monkeypatch):
    """Policies are evaluated elsewhere in this process, which is quicker than in workers; the orders that were done."""
    done = []

    def run_here(orders, at_once, on_news):
        for order in orders:
            on_news(News("started", order.folder))
            order.work.do(order.folder, lambda steps: None)
            done.append(order)
            on_news(News("ended", order.folder))

    monkeypatch.setattr("harness_plugins.transfer.jobs.run_orders", run_here)
    return done


@pytest.fixture(scope="session")
def make_network():
    """A policy of a kind of network with random weights: 5 numbers in, 2 actions or 3 choices out."""

    def make(
        kind,
        seed=0,
        *,
        layers=2,
        activation="tanh",
        is_normalised=False,
        scale=1.0,
        low=-1.0,
        high=1.0,
        **fields,
    ):
        rng = default_rng(seed)
        is_discrete, sizes = issubclass(kind, ChoosingNetwork), [5] + [4] * layers
        outputs = 3 if is_discrete else 2
        shapes = {f"hidden.{index}": (4, into) for index, into in enumerate(sizes[:-1])}
        shapes |= dict.fromkeys(kind.heads, (outputs, sizes[-1]))
        weights = {f"{layer}.weight": scale * rng.normal(size=shape) for layer, shape in shapes.items()}
        weights |= {f"{layer}.bias": scale * rng.normal(size=out) for layer, (out, _) in shapes.items()}
        if is_normalised:
            weights |= {"observation.mean": rng.normal(size=5), "observation.std": np.exp(rng.normal(size=5))}
        if kind.kind == "gaussian":
            weights["log_std"] = rng.normal(size=outputs)
        arrays = {name: array.astype(np.float32) for name, array in weights.items()}
        given = (outputs,) if is_discrete else ((low,) * outputs, (high,) * outputs)
        return kind(arrays, activation, *given, algorithm="wander", **fields)

    return make


@pytest.fixture
def ran(make_cell, make_plan, run_here, tmp_path, tmp_path_factory):
    """Two seeds of two rewards, all done; one policy was evaluated elsewhere; table and page were made."""
    kept = tmp_path_factory.getbasetemp() / "ran"
    if not kept.exists():
        _run_small(kept, make_cell, make_plan, run_here)
    return Path(shutil.copytree(kept, tmp_path / "ran"))


def _run_small(folder, make_cell, make_plan, run_here):
    arp = Choice("arp", (("k1", 1.0), ("k2", 1.5)), "arp")
    cells = [make_cell(seed=seed, reward=reward) for seed in range(2) for reward in (make_cell().reward, arp)]
    results = run_here(make_plan(*cells), folder)
    assert [manifest.status for manifest in results.manifests] == ["done"] * 4
    results.write_table()
    (folder / REPORT).write_text("<html></html>\n")
    note_made(folder / REPORT)
    elsewhere = Choice("kinematic", (), "kinematic")
    place = folder / "transfer" / cells[0].id / simulator_id(elsewhere)
    place.mkdir(parents=True)
    shutil.copy(Store(folder).cell_folder(cells[0]) / EVALUATION, place)
    TransferRecord(cells[0].id, elsewhere, "", status="done").write(place)
