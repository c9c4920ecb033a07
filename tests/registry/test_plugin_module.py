"""Plugin files that import files beside them: found, hashed, taken along, and imported for them alone."""

import json
import os
import sys
import time
from pathlib import Path

import pytest

from harness import load_registry
from harness.errors import UsageError
from harness.files.plain import from_plain, to_plain
from harness.registry import read_given, source_hash
from harness.registry.given import Given, PluginFile
from harness.registry.plugin_module import COPIES, OLD, _own_folder, file_behind, import_file

REWARD = '''
{imports}


class MyReward:
    """Pays the scale."""

    def initial_carry(self, begin_distance):
        return ()

    def __call__(self, carry, sample):
        return carry, {scale}
'''


@pytest.fixture
def lay(tmp_path):
    """Write a file; gives its path."""

    def write(name, source):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(source, encoding="utf-8")
        return tmp_path / name

    return write


def _file(path):
    (file,) = read_given([path])
    assert isinstance(file, PluginFile)
    return file


WAYS = {
    "import": ("import helpers", "helpers.SCALE"),
    "from": ("from helpers import SCALE", "SCALE"),
    "as": ("import helpers as h", "h.SCALE"),
    "relative": ("from . import helpers", "helpers.SCALE"),
    "from relative": ("from .helpers import SCALE", "SCALE"),
    "inside a function": ("def find():\n    from helpers import SCALE\n    return SCALE", "find()"),
}


@pytest.mark.parametrize(("imports", "scale"), WAYS.values(), ids=WAYS)
def test_file_beside_is_imported(lay, imports, scale):
    """In whatever way Python allows, also when the function runs."""
    lay("helpers.py", "SCALE = 2.5")
    file = _file(lay("mine.py", REWARD.format(imports=imports, scale=scale)))
    assert file.beside == (("helpers", "SCALE = 2.5"),)
    assert import_file(file).MyReward()((), None)[1] == 2.5


def test_files_beside_import_one_another(lay):
    """Directly or in a circle."""
    lay("first.py", "import second\nSCALE = 3.0\ndef other():\n    return second.other()")
    lay("second.py", "def other():\n    import first\n    return first.SCALE")
    file = _file(lay("mine.py", REWARD.format(imports="import first", scale="first.other()")))
    assert [name for name, _ in file.beside] == ["first", "second"]
    assert import_file(file).MyReward()((), None)[1] == 3.0


def test_edit_of_a_file_beside_is_another_plugin(lay):
    """Its digest counts: in the plugin's own, in its module's name and in the sources of its class."""
    path = lay("mine.py", REWARD.format(imports="import helpers", scale="helpers.SCALE"))
    digests = []
    for scale in (1.0, 2.0):
        lay("helpers.py", f"SCALE = {scale}")
        file = _file(path)
        target = load_registry([], [file]).get("rewards", "mine").load()
        assert target()((), None)[1] == scale
        assert source_hash(target) == file.digest == file.need["sha256"]
        digests.append((file.digest, file.module))
    assert len({*digests}) == 2


def test_files_beside_travel_along(lay, tmp_path):
    """As text, to processes and machines that do not have them."""
    helper = lay("helpers.py", "SCALE = 4.0")
    path = lay("mine.py", REWARD.format(imports="import helpers", scale="helpers.SCALE") + "# travels\n")
    (there,) = from_plain(tuple[Given, ...], json.loads(json.dumps(to_plain([_file(path)]))))
    helper.unlink(), path.unlink()
    assert isinstance(there, PluginFile)
    assert import_file(there).MyReward()((), None)[1] == 4.0


def test_two_plugins_may_have_files_of_one_name_beside_them(lay):
    """Each imports its own, and nobody else finds either."""
    paid = []
    for folder, scale in (("one", 1.0), ("other", 2.0)):
        lay(f"{folder}/helpers.py", f"SCALE = {scale}")
        file = _file(lay(f"{folder}/mine.py", REWARD.format(imports="import helpers", scale="helpers.SCALE")))
        paid.append(import_file(file).MyReward()((), None)[1])
    assert paid == [1.0, 2.0]
    assert "helpers" not in sys.modules


def test_modules_of_python_itself_are_meant_by_their_names(lay):
    """A reward called random.py does not take the place of Python's random."""
    lay("random.py", "raise RuntimeError")
    file = _file(lay("mine.py", REWARD.format(imports="import random", scale="random.Random(0).random()")))
    assert file.beside == ()
    assert 0 < import_file(file).MyReward()((), None)[1] < 1


def test_code_is_known_by_its_file(lay):
    """Also that of a file beside it; other code has none."""
    lay("helpers.py", "def pay():\n    return 1.0")
    file = _file(lay("mine.py", REWARD.format(imports="from helpers import pay", scale="pay()")))
    module = import_file(file)
    assert file_behind(module.MyReward) == file_behind(module.pay) == file
    assert file_behind(Path) is None


@pytest.mark.parametrize(
    ("helper", "told"),
    [
        ("x = 1\nraise ValueError('no')", r"ValueError: no \(line 2 of helpers\.py\)"),
        ("def (", r"SyntaxError"),
        ("import no_such_lib", r"No module named 'no_such_lib' \(line 1 of helpers\.py\)"),
        ("from .other import x", r"No module named '\.other' beside it"),
    ],
)
def test_file_beside_that_fails_is_named(lay, helper, told):
    """With its line; nothing of it stays imported."""
    lay("helpers.py", helper)
    path = lay("mine.py", REWARD.format(imports="import helpers", scale="0"))
    with pytest.raises(UsageError, match=rf"Plugin file '.*mine\.py' cannot be loaded: .*{told}"):
        import_file(_file(path))
    assert not [name for name in sys.modules if name.startswith(_file(path).module)]


def test_too_many_files_beside_are_refused(lay):
    """They should be a package."""
    for number in range(101):
        lay(f"part_{number}.py", "")
    path = lay("mine.py", "\n".join(f"import part_{number}" for number in range(101)))
    with pytest.raises(UsageError, match=r"imports more than 100 files.*install them as a package"):
        read_given([path])


@pytest.mark.parametrize(
    ("name", "age", "stays"),
    [
        (f"{COPIES}999999999-x", 2.0 * OLD, False),
        (f"{COPIES}999999999-x", 0.0, True),
        (f"{COPIES}OURS-x", 2.0 * OLD, True),
        (f"{COPIES}mine", 2.0 * OLD, True),
        ("other", 2.0 * OLD, True),
    ],
)
def test_folders_of_killed_processes_are_removed(tmp_path, monkeypatch, name, age, stays):
    """Old ones alone, of processes that are gone."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    left = tmp_path / name.replace("OURS", str(os.getpid()))
    left.mkdir()
    os.utime(left, (time.time() - age,) * 2)
    _own_folder.__wrapped__().cleanup()
    assert left.exists() == stays
