"""Each extra alone, and all together: what it brings works, in an environment that has nothing else."""

import tomllib
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import pytest

from harness_plugins.descriptions.xacro_file import EXAMPLE
from tests.installed.conftest import ROOT
from tests.robot.brought_arms import changed
from tests.robot.test_meshes import CORNERS, collada

pytestmark = pytest.mark.slow

FEW = ("--steps", "60", "--evaluation-episodes", "1", "--seeds", "1", "--jobs", "1", "--out", "out")
ARM = ("run", "--algo", "ik", "--reward", "dense", *FEW, "--sim")
KINEMATIC = ("run", "--sim", "kinematic", "--reward", "dense", *FEW, "--algo")
COLLIDING = changed(
    (
        '<link name="l4">',
        '<link name="l4"><collision><geometry><mesh filename="part.dae"/></geometry></collision>',
    )
)
"""An arm that is read only with its mesh."""
ENV = ("run", "--algo", "random", *FEW, "--task")


class Use(NamedTuple):
    """What an extra brings, as a user would use it."""

    commands: tuple[tuple[str, ...], ...]
    makes: str = "out/report.html"
    """A file that is there afterwards."""
    needs: Mapping[str, str] = MappingProxyType({})
    """The content of files that are there before, by name."""


USES = {
    "mujoco": Use(((*ARM, "mujoco"),)),
    "pybullet": Use(((*ARM, "pybullet"),)),
    "dm-control": Use(((*ARM, "dm_control"),)),
    "gymnasium": Use(
        (
            (*ENV, "gymnasium:id=InvertedPendulum-v5", "--reward", "own,own"),
            ("report", "out", "--json"),
            ("verify", "out"),
        ),
        "out/plan.json",
    ),
    "robotics": Use(((*ENV, "fetch-reach"),)),
    "metaworld": Use(((*ENV, "meta-world:episode_steps=20"),)),
    "sb3": Use(((*KINEMATIC, "ppo:num_envs=1,rollout=60,batch_size=30"),)),
    "ray": Use(((*KINEMATIC, "ik", "--executor", "ray"),)),
    "slurm": Use((("describe", "executors"),), ""),
    "export": Use(((*KINEMATIC, "sac-fast"), ("export", "out/cells", "--onnx", "policy.onnx")), "policy.onnx"),
    "meshes": Use((("describe", "arm.urdf"),), "part.dae", {"arm.urdf": COLLIDING, "part.dae": collada(CORNERS / 10)}),
    "xacro": Use((("describe", "arm.urdf.xacro"),), "arm.urdf.xacro", {"arm.urdf.xacro": EXAMPLE}),
    "report": Use(((*KINEMATIC, "ik"),)),
    "video": Use(((*KINEMATIC, "ik"), ("video", "out", "--episodes", "1", "--out", "film.gif")), "film.gif"),
    "tensorboard": Use(((*KINEMATIC, "ik", "--tracker", "tensorboard"),), "out/tensorboard"),
    "wandb": Use(((*KINEMATIC, "ik", "--tracker", "wandb:mode=offline"),), "wandb"),
}
"""By extra."""
ELSEWHERE = {
    "drake": "make engines", "physx": "make engines", "mjx": "make engines",
    "unity": "make unity",
    "minari": "make test",
    "all": "test_all_extras_together",
}  # fmt: skip
"""Extras that are tried somewhere else."""
APART = ("robotics", "metaworld")
"""Not part of all: they take an older MuJoCo."""


def test_every_extra_is_tried():
    """Here or elsewhere."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert {*USES, *ELSEWHERE} == set(project["optional-dependencies"])


def _use(env, use, folder):
    for name, content in use.needs.items():
        (folder / name).write_text(content)
    for arguments in use.commands:
        given = [_cell_in(folder) if argument == "out/cells" else argument for argument in arguments]
        status, out, err = env.harness(*given, cwd=folder, MUJOCO_GL="egl")
        assert status == 0, f"{arguments}\n{out}{err}"
        assert "Traceback" not in err
    assert (folder / use.makes).exists(), use


def _cell_in(folder):
    """The folder of the one cell that trained with another reward than the baseline."""
    return next(str(path) for path in sorted((folder / "out/cells").iterdir()))


@pytest.mark.parametrize("extra", USES)
def test_extra_brings_all_that_it_needs(with_extras, tmp_path, extra):
    """It is used, and the doctor agrees."""
    env = with_extras((extra,))
    _use(env, USES[extra], tmp_path)
    status, out, _ = env.harness("doctor", cwd=tmp_path)
    assert status == 0, out


def test_all_extras_together(with_extras, tmp_path):
    """They can be installed beside one another, and each still does what it did alone."""
    env = with_extras(("all",))
    for extra, use in USES.items():
        if extra not in APART:
            (tmp_path / extra).mkdir()
            _use(env, use, tmp_path / extra)
    assert env.harness("doctor", cwd=tmp_path).status == 0
