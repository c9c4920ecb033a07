"""MuJoCo's frames without a display: drawn unasked, or refused in one line as often as asked, and nothing else fails.

In processes of their own: what MuJoCo renders with is chosen once, and what goes wrong may end the process.
"""

from functools import partial

import mujoco
import numpy as np
import pytest

from harness_plugins.mujoco_model import Renderer, build_model
from tests.refusals import refused
from tests.registered import FD100

UNUSABLE = ("glfw", "off", "nonsense", "osmesa")
"""Values of MUJOCO_GL that render nothing on a machine without a display and without OSMesa."""
ENVS = """
import gc, os, sys, harness
from harness.errors import UsageError
def make(simulator={simulator!r}):
    env = harness.make_env(simulator)
    env.reset(seed=0)
    return env
"""
REFUSED = """
def refusal(env):
    try:
        env.render()
    except UsageError as error:
        return str(error)
one, other = make(), make()
told = [refusal(one), refusal(one), refusal(other)]
assert told[0] and set(told) == {told[0]}, told
del one, other
gc.collect()
sys.stdout.write(told[0])
"""

slow = partial(pytest.param, marks=pytest.mark.slow)  # another case shows the same
mujoco_engines = pytest.mark.parametrize("simulator", ["dm_control", "mujoco"])


@pytest.fixture(scope="session")
def has_osmesa(run_without_display):
    """Whether OSMesa renders here; found by trying."""
    code = "from mujoco.osmesa import GLContext\nGLContext(8, 8).make_current()"
    return run_without_display(code, library="osmesa").returncode == 0


@pytest.fixture
def run(run_without_display, simulator, library, has_osmesa):
    """What code with envs at hand writes on stdout; it has to end well and to say nothing on stderr."""
    if library == "osmesa" and has_osmesa:
        pytest.skip("OSMesa is installed here: its absence cannot be tried")

    def call(code, **options):
        done = run_without_display(ENVS.format(simulator=simulator) + code, library=library, **options)
        assert (done.returncode, done.stderr) == (0, "")
        return done.stdout

    return call


@pytest.fixture
def library():
    """MUJOCO_GL where a test does not say otherwise: not set."""
    return None


@mujoco_engines
def test_two_envs_render_in_a_row_unasked(egl, run):
    """Without a display and without MUJOCO_GL frames are drawn, in a second env as in the first."""
    run("frames = [make().render()[0] for _ in range(2)]\nassert all(frame.std() > 10.0 for frame in frames)")


@pytest.mark.parametrize("simulator", ["mujoco"])  # the renderer of both
def test_who_imported_mujoco_does_not_matter(egl, run):
    """Frames are drawn also where MuJoCo was imported before, without a thought of rendering."""
    run("import mujoco\nassert make().render()[0].std() > 10.0")


@mujoco_engines
def test_rendering_changes_no_environment_variable(egl, run):
    """Processes that are started after a frame was drawn choose for themselves."""
    run("make().render()\nassert not {'MUJOCO_GL', 'PYOPENGL_PLATFORM'} & set(os.environ)")


@pytest.mark.parametrize("simulator", ["mujoco"])  # the renderer of both
@pytest.mark.parametrize(
    "end",
    ["", slow("del one, other\ngc.collect()"), "one.close()", slow("one.close()\nother.close()")],
)
def test_renderers_close_quietly(egl, run, end):
    """Nothing is printed, whether envs are closed, forgotten, or left open until the interpreter ends."""
    run(f"one, other = make(), make()\none.render()\nother.render()\n{end}", warnings="error")


@pytest.mark.parametrize(
    ("simulator", "library"),
    [*(("mujoco", library) for library in UNUSABLE), ("dm_control", "glfw"),
     *(slow("dm_control", library) for library in UNUSABLE if library != "glfw")],
)  # fmt: skip
def test_library_that_cannot_render_costs_the_frames_alone(run, library):
    """Arms move, and every frame is a UsageError that says in one line what to install; the choice stays the user's."""
    told = run(
        "env = make()\nstart = env.episodes.qpos.copy()\n"
        "env.step(env.action_space.high)\n"
        f"assert (env.episodes.qpos != start).all()\n{REFUSED}"
        f"assert os.environ['MUJOCO_GL'] == {library!r}"
    )
    assert "\n" not in told
    assert "install libegl1" in told


@pytest.mark.parametrize(("simulator", "library"), [("mujoco", "glfw")])
def test_failing_render_leaves_nothing_to_complain_of(run):
    """Where warnings are errors, a window that cannot be opened is one UsageError, and its remains go quietly."""
    assert "GLFW opens no window" in run(REFUSED, warnings="error")


@pytest.mark.parametrize("simulator", ["mujoco"])
def test_machine_without_egl_says_what_to_install(run):
    """Where the library is missing that would be taken unasked, the line names it."""
    told = run(f"sys.modules['mujoco.egl'] = None\n{REFUSED}")
    assert "cannot render here without MUJOCO_GL" in told
    assert "install libegl1" in told


@pytest.mark.parametrize(("simulator", "library"), [("mujoco", "glfw")])
def test_context_that_mujoco_cannot_draw_into_is_not_tried_again(run):
    """MuJoCo aborts the interpreter where it draws twice without a context; a second frame is refused before."""
    nothing = "type('GLContext', (), {'__init__': lambda *_: None, 'make_current': lambda _: None})"
    run(f"make()\nimport mujoco\nmujoco.GLContext = {nothing}\n{REFUSED}")


@pytest.mark.parametrize(("simulator", "library"), [("mujoco", "osmesa")])
def test_training_works_where_nothing_renders(run, simulator):
    """A training, which renders nothing, is done with a MUJOCO_GL that cannot work."""
    given = "algo='random', reward=[], seeds=1, steps=40, evaluation_episodes=2, jobs=1"
    told = run(
        "import tempfile\n"
        f"results = harness.run(out=tempfile.mkdtemp(), sim={simulator!r}, {given}, task='fd100-reach:horizon=20')\n"
        "sys.stdout.write(str([(cell.status, cell.reason) for cell in results.manifests]))"
    )
    assert told == "[('done', '')]"


def test_macos_and_windows_choose_nothing(monkeypatch):
    """Beside Linux the context is the one that MuJoCo has, and where it fails there is nothing to install."""

    def fail(*_):
        raise RuntimeError("this is no Linux")

    monkeypatch.setattr("sys.platform", "darwin")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(mujoco, "GLContext", fail, raising=False)
    renderer = Renderer(build_model(FD100, 0.005, 100.0), FD100)
    with refused(r"this is no Linux\): leave MUJOCO_GL unset"):
        renderer.frame(FD100.home, np.zeros(3), 64, 48)
