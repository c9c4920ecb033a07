import pytest


@pytest.fixture
def without_rendering(monkeypatch):
    """Rendering takes seconds, and is tested with the simulator."""
    monkeypatch.setattr("harness.cli.doctor._try_rendering", lambda backend: f"{backend or 'nothing'} tried")


def test_versions_machine_and_rendering_are_told(harness, without_rendering):
    """The doctor says what is installed, on what machine, and how each way of rendering goes."""
    out = harness("doctor").out
    for text in (
        "python 3",
        "cpu ",
        "numpy ",
        "plugins ",
        "MUJOCO_GL=egl: egl tried",
        "without MUJOCO_GL: nothing tried",
    ):
        assert text in out


def test_rendering_that_fails_says_what_to_install(harness, monkeypatch):
    """A way of rendering that is not there names the system package that brings it."""
    monkeypatch.setattr("harness.cli.doctor._try_rendering", lambda backend: "")
    out = harness("doctor").out
    assert "rendering MUJOCO_GL=egl: fails here: install libegl1" in out
    assert "rendering MUJOCO_GL=osmesa: fails here: install libosmesa6" in out
    assert "rendering without MUJOCO_GL: fails here: install libegl1" in out


def test_rendering_has_no_choice_beside_linux(harness, without_rendering, monkeypatch):
    """On macOS and Windows there is one way of rendering, and no package to install for it."""
    monkeypatch.setattr("sys.platform", "darwin")
    out = harness("doctor").out
    assert "rendering nothing tried" in out
    assert "MUJOCO_GL" not in out


def test_missing_libraries_come_with_their_extra(harness, without_rendering, monkeypatch):
    """What is missing says what to install."""
    monkeypatch.setattr("harness.registry.registry._is_installed", lambda module: module != "stable_baselines3")
    out = harness("doctor").out
    assert "missing stable_baselines3 for algorithm 'sac': pip install 'fd100-harness[sb3]'" in out


def test_broken_plugins_are_told(harness, without_rendering, toy_folder, tmp_path, monkeypatch):
    """A plugin that cannot be imported is named with the reason, and the doctor goes on."""
    package = tmp_path / "broken-1.0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n")
    (package / "entry_points.txt").write_text("[harness]\nbad = no_such_module\n")
    monkeypatch.syspath_prepend(tmp_path)
    out = harness("doctor").out
    assert "plugin 'bad' of broken is broken: ModuleNotFoundError" in out
    assert "versions" in out
