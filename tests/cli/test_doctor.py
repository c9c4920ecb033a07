def test_versions_machine_and_rendering_are_told(harness, rendering):
    """The doctor says what is installed, on what machine, and how each way of rendering goes."""
    rendering("true")
    status, out, _ = harness("doctor")
    assert status == 0
    for text in ("python 3", "cpu ", "numpy ", "plugins ", "MUJOCO_GL=egl: works", "without MUJOCO_GL: works"):
        assert text in out


def test_rendering_that_fails_says_what_to_install(harness, rendering):
    """A way of rendering that is not there names the system package that brings it."""
    rendering("false")
    out = harness("doctor").out
    assert "rendering MUJOCO_GL=egl: fails here: install libegl1" in out
    assert "rendering MUJOCO_GL=osmesa: fails here: install libosmesa6" in out
    assert "rendering without MUJOCO_GL: fails here: install libegl1" in out


def test_rendering_has_no_choice_beside_linux(harness, rendering, monkeypatch):
    """On macOS and Windows there is one way of rendering, and no package to install for it."""
    rendering("true")
    monkeypatch.setattr("sys.platform", "darwin")
    out = harness("doctor").out
    assert "rendering works" in out
    assert "MUJOCO_GL" not in out


def test_missing_libraries_come_with_their_extra(harness, rendering, distant):
    """What is missing says what to install."""
    rendering("true")
    assert "missing no_such_engine for simulator 'distant': pip install 'far-away[engine]'" in harness("doctor").out


def test_what_lacks_the_same_library_stands_in_one_line(harness, rendering, install):
    """With the names in order."""
    rendering("true")
    source = (
        "import harness\n@harness.hookimpl\ndef register_rewards(register):\n    for name in ('far', 'away'):\n"
        "        register(name, 'no:where', summary='far', requires=['no_such_library'], extra='far')\n"
        "@harness.hookimpl\ndef register_logs(register):\n    for name in ('bags', 'tapes'):\n"
        "        register(name, 'no:where', summary='far', requires=['no_such_player'], extra='far')\n"
    )
    install("far-away", source)
    out = harness("doctor").out
    assert "missing no_such_library for rewards away, far: pip install 'far-away[far]'" in out
    assert out.count("no_such_library") == 1
    assert "missing no_such_player for log formats bags, tapes: pip install 'far-away[far]'" in out


def test_broken_plugins_are_told(harness, rendering, install):
    """A plugin that cannot be imported is named with the reason, and the doctor goes on."""
    rendering("true")
    install("broken", "import no_such_module")
    status, out, _ = harness("doctor")
    assert "plugin 'broken' of broken 1.0 is broken: ModuleNotFoundError" in out
    assert "versions" in out
    assert status == 1


def test_plugins_are_told_with_their_versions(harness, rendering, monkeypatch):
    """With what packages of others registered. HARNESS_PLUGINS turns some off, and a name of none in it is told."""
    rendering("true")
    assert "  toy-arm 1.0: toys (simulator ideal" in harness("doctor").out
    monkeypatch.setenv("HARNESS_PLUGINS", "-simulators,-toys,-ryas")
    out = harness("doctor").out
    assert ", simulators (off), tasks, " in out
    assert "  toy-arm 1.0: toys (off)\n" in out
    assert "HARNESS_PLUGINS names 'ryas', which is no plugin." in out


def test_a_target_that_does_not_exist_makes_its_plugin_broken(harness, rendering, install):
    """Without importing what it stands in; what was meant is offered."""
    rendering("true")
    hook = "import harness\n@harness.hookimpl\ndef register_rewards(register):\n"
    line = "    register('mine', __name__ + '_code:Mnie', summary='')\n"
    module = install("typos", hook + line, code="raise SystemExit\nclass Mine: ...\n")
    status, out, _ = harness("doctor")
    told = f"Reward 'mine' of package typos 1.0: module '{module}_code' has no 'Mnie'. Did you mean 'Mine'?"
    assert f"plugin 'typos' of typos 1.0 is broken: {told}\n" in out
    assert "  typos 1.0: typos (broken)\n" in out
    assert status == 1


def test_what_can_be_run_is_told_last(harness, rendering):
    """With what is installed."""
    rendering("true")
    simulators, algorithms, last = harness("doctor").out.splitlines()[-3:]
    assert simulators.startswith("installed simulators: ")
    assert "ideal" in simulators
    assert "wander" in algorithms
    assert last.startswith("you can run: harness run --sim ")


def test_what_is_optional_stands_apart(harness, rendering, distant):
    """Below its heading, behind what works: nobody reads a missing extra as a fault."""
    rendering("true")
    out = harness("doctor").out
    places = [
        out.index(it)
        for it in (
            "Works here:",
            "MUJOCO_GL=egl: works",
            "Optional, and not installed.",
            "missing no_such_engine",
            "you can run",
        )
    ]
    assert places == sorted(places)
