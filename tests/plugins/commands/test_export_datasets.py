"""``harness export --minari`` and ``--lerobot``: what was recorded is read back, and paid again, as it was."""

import importlib
import json
from itertools import product
from pathlib import Path

import gymnasium
import numpy as np
import pytest

import harness
from harness.cli import main
from harness.payoff.dataset.arm_pay import of_arm
from harness.payoff.dataset.paid_dataset import pay_dataset
from harness.payoff.dataset.rewards import Recorded
from harness.payoff.dataset.step_by_step import step_by_step
from harness.record.folder import EVALUATION, TRACE
from harness.record.recording.recorded_training import read_recording
from harness.record.trace import read_trace
from harness.registry.choice import choose
from harness.registry.registry import load_registry
from harness.results import load_results
from harness.score.places import parse_places
from harness_plugins.audit.dataset.audit_dataset import audit_dataset
from tests.record.dataset.written import opened

export_command = importlib.import_module("harness_plugins.exporters.command")  # not the function of that name
REWARDS = ("arp", "dense")
FORMATS = {"minari": 1e-12, "lerobot": 1e-6}
"""How far a number may be off: those of LeRobot are float32."""


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two rewards, trained for a moment in the kinematic simulator."""
    folder = tmp_path_factory.mktemp("trained") / "runs"
    harness.run(
        sim="kinematic", algo="random", reward=REWARDS, seeds=1, steps=450, evaluation_episodes=4, out=folder, jobs=1
    )
    return folder


@pytest.fixture(scope="module")
def exported(trained: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Both formats of it."""
    place = tmp_path_factory.mktemp("exported")
    _export(trained, place)
    return place


def _export(folder: Path, place: Path) -> int:
    with pytest.raises(SystemExit) as stopped:
        main(["export", str(folder), "--minari", str(place / "minari"), "--lerobot", str(place / "lerobot")])
    return int(stopped.value.code or 0)


def _dataset(place: Path, form: str, kind: str):
    (folder,) = (place / form).glob(f"**/{kind}-v0")
    return opened(f"{form}:{folder}")


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize(("kind", "file"), [("training", TRACE), ("evaluation", EVALUATION)])
def test_steps_are_those_of_the_traces(trained: Path, exported: Path, form: str, kind: str, file: str):
    """All that were taken, with what the learner was paid."""
    results = load_results(trained)
    traces = [read_trace(results.store.cell_folder(cell) / file) for cell in results.done_cells]
    paid = np.concatenate(
        [sum(it[name] for name in ("reward", "reward_ground", "reward_target", "reward_step")) for it in traces]
    )
    taken = np.concatenate([it["step"] > 0 for it in traces])
    found = _dataset(exported, form, kind)["reward/recorded"]
    assert sorted(found) == pytest.approx(sorted(paid[taken]), abs=FORMATS[form])


def test_rewards_paid_again_are_those_recorded(exported: Path, subtests: pytest.Subtests):
    """From the positions in the observation."""
    for (form, bound), kind, name in product(FORMATS.items(), ["training", "evaluation"], ["baseline", *REWARDS]):
        with subtests.test(form=form, kind=kind, name=name):
            found = _dataset(exported, form, kind)
            names = json.loads((found.facts.path / "data" / "metadata.json").read_text()) if form == "minari" else {}
            width = found["observation"].shape[1]
            assert not names or names["observation_names"][-3:] == ["target_x", "target_y", "target_z"]
            places = parse_places(f"end_effector={width - 6}:{width - 3},target={width - 3}:{width}")
            registry = load_registry()
            again = of_arm(choose(registry, "rewards", name).build(registry, "rewards"), places)
            paid = pay_dataset(found, {"recorded": Recorded(name), "again": again}, places).paid
            assert paid["again"] == pytest.approx(paid["recorded"], abs=bound)


@pytest.mark.parametrize("form", FORMATS)
def test_success_is_a_reached_target(trained: Path, exported: Path, form: str):
    """Of each episode of the evaluations."""
    results = load_results(trained)
    reached = 0
    for cell in results.done_cells:
        trace = read_trace(results.store.cell_folder(cell) / EVALUATION)
        reached += sum(bool(trace["reached"][rows].any()) for rows in trace.episodes)
    found = pay_dataset(_dataset(exported, form, "evaluation"), {"it": Recorded("recorded")})
    assert (found.told == 1).sum() == reached


def test_both_formats_say_the_same(exported: Path):
    """But for rounding."""
    one, other = (_dataset(exported, form, "evaluation") for form in FORMATS)
    for name in ("before/observation", "observation", "action"):
        assert other[name] == pytest.approx(one[name], abs=1e-6)
    assert other["info/next.distance"] == pytest.approx(one["info/distance"], abs=1e-6)
    assert "seen" not in other


@pytest.mark.parametrize("kind", ["training", "evaluation"])
def test_both_formats_get_the_same_answer(exported: Path, kind: str):
    """Intervals are over the trainings in both; the same episodes are equal."""
    one, other = (audit_dataset(_dataset(exported, form, kind).facts.name) for form in FORMATS)
    assert one.clusters == other.clusters
    assert one.clusters[0] == "operators"
    assert (one.episodes, one.successes, one.failures) == (other.episodes, other.successes, other.failures)
    for first, second in zip(one.rewards, other.rewards, strict=True):
        assert (first.by_success.answer, first.by_success.clusters) == (
            second.by_success.answer,
            second.by_success.clusters,
        )


def test_minari_reads_what_was_written(exported: Path):
    """Its own library, where it is installed."""
    minari = pytest.importorskip("minari")
    (folder,) = (exported / "minari").glob("**/evaluation-v0")
    found = minari.MinariDataset(folder / "data")
    one = found[0]
    log = _dataset(exported, "minari", "evaluation")
    rows = log.rows().part(log["episode"] == 0)
    assert np.array_equal(one.observations[1:], rows["observation"])
    assert np.array_equal(one.rewards, rows["reward/recorded"])
    assert found.total_steps == len(log)


def test_a_folder_that_is_there_is_not_written_into(trained: Path, exported: Path, capsys: pytest.CaptureFixture[str]):
    """One line, and nothing is lost."""
    before = sorted(path for path in exported.rglob("*"))
    assert _export(trained, exported) == 2
    assert "is there already: name another folder" in capsys.readouterr().err
    assert sorted(path for path in exported.rglob("*")) == before


class Plane(gymnasium.Env):
    """A point that is pushed; a table of two parts is seen."""

    observation_space = gymnasium.spaces.Dict(
        {"place": gymnasium.spaces.Box(-9.0, 9.0, (2,)), "push": gymnasium.spaces.Box(-9.0, 9.0, (1,))}
    )
    action_space = gymnasium.spaces.Box(-1.0, 1.0, (2,))

    def reset(self, *, seed=None, options=None):
        """Somewhere."""
        super().reset(seed=seed)
        self.place, self.steps = self.np_random.uniform(-1.0, 1.0, 2).astype(np.float32), 0
        return self._seen(np.zeros(2)), {}

    def step(self, action):
        """A little way."""
        self.place = (self.place + 0.1 * np.asarray(action)).astype(np.float32)
        self.steps += 1
        near = bool(np.linalg.norm(self.place) < 0.5)
        return self._seen(action), -float(np.linalg.norm(self.place)), near, self.steps >= 20, {"success": float(near)}

    def _seen(self, action):
        return {"place": self.place, "push": np.float32([np.linalg.norm(action)])}


def _near(observation, action, next_observation, info):
    return -float(np.abs(next_observation["place"]).max())


def _record(folder: Path) -> None:
    env = harness.RecordRewards(
        gymnasium.make("tests/Plane-v0"),
        folder,
        trained_with="own",
        rewards={"near": _near},
        behaviour={"success": "success"},
    )
    rng = np.random.default_rng(0)
    env.reset(seed=3)
    for _ in range(90):
        _, _, terminated, truncated, _ = env.step(rng.uniform(-1.0, 1.0, 2).astype(np.float32))
        if terminated or truncated:
            env.reset()
    env.close()


@pytest.fixture
def recorded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A recording in an environment of anybody."""
    if "tests/Plane-v0" not in gymnasium.registry:
        gymnasium.register("tests/Plane-v0", entry_point=Plane)
    _record(tmp_path / "recorded" / "one")
    return tmp_path / "recorded"


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("form", FORMATS)
def test_a_recording_in_an_environment_is_paid_again(recorded: Path, tmp_path: Path, form: str):
    """Its actions are taken again to learn what was seen; the rewards are those that were recorded live."""
    assert _export(recorded, tmp_path / "out") == 0
    found = _dataset(tmp_path / "out", form, "recorded")
    live = read_recording(recorded / "one")
    again = _near if form == "minari" else lambda o, a, n, i: -float(np.abs(n[:2]).max())
    paid = pay_dataset(
        found, {"near": Recorded("near"), "own": Recorded("own"), "again": step_by_step("it", again)}
    ).paid
    assert paid["own"] == pytest.approx(live["reward/own"], abs=FORMATS[form])
    assert paid["near"] == pytest.approx(live["reward/near"], abs=FORMATS[form])
    assert paid["again"] == pytest.approx(live["reward/near"], abs=FORMATS[form])


@pytest.mark.filterwarnings("ignore")
def test_tables_stay_tables_in_minari(recorded: Path, tmp_path: Path):
    """With the keys of the environment; LeRobot has one vector."""
    _export(recorded, tmp_path / "out")
    one, other = (_dataset(tmp_path / "out", form, "recorded") for form in FORMATS)
    seen = {name for name in one.names if name.startswith("observation")}
    assert seen == {"observation/place", "observation/push"}
    assert other["observation"].shape[1] == 3


@pytest.mark.parametrize("flag", ["--csv", "--onnx", "--torchscript"])
def test_other_forms_are_refused_beside_them(
    trained: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], flag: str
):
    """One call writes one kind of thing."""
    more = [flag] if flag == "--csv" else [flag, "model"]
    with pytest.raises(SystemExit) as stopped:
        main(["export", str(trained), "--minari", str(tmp_path / "m"), *more])
    assert stopped.value.code == 2
    assert "--minari and --lerobot go without other forms" in capsys.readouterr().err


@pytest.mark.parametrize("form", FORMATS)
def test_a_killed_export_is_done_by_the_same_command(trained: Path, tmp_path: Path, monkeypatch, form: str):
    """What it left half written, and what it had finished, is replaced; nothing is left beside."""
    publish, done = export_command.publish, []

    def killed(partial: Path, whole: Path) -> None:
        done.append(whole)
        if len(done) == 2:
            raise KeyboardInterrupt
        publish(partial, whole)

    with monkeypatch.context() as patch:
        patch.setattr(export_command, "publish", killed)
        patch.setattr(export_command.shutil, "rmtree", lambda *given, **more: None)  # a kill removes nothing
        with pytest.raises((KeyboardInterrupt, SystemExit)):
            main(["export", str(trained), f"--{form}", str(tmp_path / form)])
    assert any(path.name.startswith(".") for path in (tmp_path / form).rglob("*"))
    with pytest.raises(SystemExit) as stopped:
        main(["export", str(trained), f"--{form}", str(tmp_path / form)])
    assert not stopped.value.code
    assert not [path for path in (tmp_path / form).rglob("*") if path.name.startswith(".")]
    assert _dataset(tmp_path, form, "training").facts.path.is_dir()
