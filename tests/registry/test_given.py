"""Plugins that are given by hand: files, classes, and each way in which one can be wrong."""

import dataclasses
import hashlib
import json

import pytest

from harness import load_registry
from harness.errors import UsageError
from harness.files.plain import from_plain, to_plain
from harness.registry import choose, read_given, require_given, source_hash
from harness.registry.given import Given, PluginClass, PluginFile, class_given, plugin_flags

REWARD = '''
from dataclasses import dataclass

@dataclass(frozen=True)
class MyReward:
    """Pays the way that a step gained."""

    scale: float = 1.0

    def initial_carry(self, begin_distance):
        return ()

    def __call__(self, carry, sample):
        return carry, self.scale * (sample.previous_distance - sample.distance)
'''
HOOKED = f"""
import harness

@harness.hookimpl
def register_rewards(register):
    register("hooked", f"{{__name__}}:MyReward", summary="pays")
    register("twin", f"{{__name__}}:MyReward", summary="pays too")
{REWARD}
"""


@pytest.fixture
def lay(tmp_path):
    """Write a file; gives its path."""

    def write(source=REWARD, name="my_reward.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(source, encoding="utf-8")
        return tmp_path / name

    return write


def test_file_without_hooks_registers_its_class_under_its_own_name(lay):
    """Fifteen lines are a plugin: kind and summary are read off the class."""
    registry = load_registry([], read_given([lay()]))
    spec = registry.get("rewards", "my_reward")
    assert (spec.summary, spec.package) == ("Pays the way that a step gained.", f"my_reward.py {_digest(lay())[:8]}")
    assert choose(registry, "rewards", "my_reward:scale=2").build(registry, "rewards").scale == 2.0
    assert len([line for line in REWARD.splitlines() if line]) <= 15


def test_file_with_hooks_registers_by_them(lay):
    """As a package does."""
    assert load_registry([], read_given([lay(HOOKED)])).names("rewards") == ["hooked", "twin"]


def _digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_sources_of_a_file_are_its_bytes(lay):
    """As they were read: the manifest names their SHA-256, and the same text is one module in every process."""
    path = lay()
    (given,), digest = read_given([path]), _digest(path)
    assert isinstance(given, PluginFile)
    assert dataclasses.replace(given, path="/elsewhere/my_reward.py").module == given.module
    target = load_registry([], [given]).get("rewards", "my_reward").load()
    path.unlink()  # it may be edited or removed while cells run by it
    assert source_hash(target) == digest == given.need["sha256"]


def test_file_that_is_not_there_any_more_is_loaded_from_its_text(lay):
    """As on another machine; the sources stay those that were read."""
    path = lay(REWARD + "\n# elsewhere\n")
    given, digest = from_plain(tuple[Given, ...], json.loads(json.dumps(to_plain(read_given([path]))))), _digest(path)
    path.unlink()
    target = load_registry([], given).get("rewards", "my_reward").load()
    assert source_hash(target) == digest


def test_edited_file_is_another_module(lay):
    """A notebook that reads the file again runs what it says now."""
    factors = []
    for factor in (2, 3):
        path = lay(REWARD.replace("scale: float = 1.0", f"scale: float = {factor}.0"))
        factors.append(load_registry([], read_given([path])).get("rewards", "my_reward").load()().scale)
    assert factors == [2.0, 3.0]


def test_nothing_is_left_beside_the_file(lay):
    """No compiled copy, which could be an old one."""
    path = lay(REWARD + "\n# alone\n")
    load_registry([], read_given([path]))
    assert [it.name for it in path.parent.iterdir()] == ["my_reward.py"]


BAD = {
    "does not parse": ("def", "cannot be loaded: SyntaxError: invalid syntax (my_reward.py, line 1)"),
    "raises": ("x = 1\ny = {}['a']", "cannot be loaded: KeyError: 'a' (line 2)"),
    "leaves": ("raise SystemExit(3)", "cannot be loaded: SystemExit: 3 (line 1)"),
    "misses a library": ("import no_such_lib", "ModuleNotFoundError: No module named 'no_such_lib' (line 1)"),
    "nothing": ("x = 1", "registers nothing: without hooks it needs one public class, it has none"),
    "two classes": ("class A: ...\nclass B: ...", "it has A, B. Begin the names of others with _"),
    "no kind": ("class A: ...", "A has no "),
    "half a reward": (REWARD.replace("__call__", "pay"), "MyReward has no __call__; a reward has initial_carry"),
    "another call": (REWARD.replace("carry, sample", "sample"), "__call__ takes 2 arguments beside self"),
    "mistyped hook": (HOOKED.replace("register_rewards", "register_reward"), "Did you mean 'register_rewards'?"),
    "hook that raises": (HOOKED.replace("summary=", "sumary="), "its hooks raise TypeError"),
    "empty hook": ("import harness\n@harness.hookimpl\ndef register_rewards(register): ...", "registers nothing"),
    "NUL": ("\0", "cannot be loaded: "),
}


@pytest.mark.parametrize(("source", "told"), BAD.values(), ids=BAD)
def test_bad_file_is_told_in_one_line(lay, source, told):
    """With the file, and the line where that is known; it was asked for, so it is an error."""
    with pytest.raises(UsageError) as error:
        load_registry([], read_given([lay(source)]))
    assert told in str(error.value)
    assert f"Plugin file '{lay(source)}'" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ("missing.py", "Plugin file 'missing.py' cannot be read: No such file or directory"),
        (".", "'.' is no Python file: give one, my_reward.py"),
        ("notes.txt", "'notes.txt' is no Python file"),
        ("no_such_module_here:Mine", "Plugin 'no_such_module_here:Mine' cannot be imported: ModuleNotFoundError"),
        ("json.decoder:JSONDecoder", "JSONDecoder has no "),
    ],
)
def test_what_is_no_plugin_is_told(asked, told):
    """Before anything is loaded."""
    with pytest.raises(UsageError) as error:
        read_given([asked])
    assert told in str(error.value)


def test_file_that_is_no_text_is_told(tmp_path):
    """It is not decoded somehow."""
    (tmp_path / "mine.py").write_bytes(b"\xff\xfe")
    with pytest.raises(UsageError, match=r"Plugin file '.*mine\.py' cannot be read: 'utf-8' codec"):
        read_given([tmp_path / "mine.py"])


def test_two_files_of_one_name_are_refused(lay):
    """Reports could not tell them apart; one that is named twice is one."""
    one, two = lay(), lay(REWARD + "\n", "b/my_reward.py")
    assert len(read_given([one, one])) == 1
    with pytest.raises(UsageError, match=r"Two plugin files are called my_reward\.py: .* Rename one"):
        read_given([one, two])


def test_name_that_is_taken_is_refused(lay):
    """A built-in one, and one of another file."""
    with pytest.raises(UsageError, match=r"reward 'arp' is taken by package fd100-harness .* Rename the file"):
        load_registry(given=read_given([lay(name="arp.py")]))
    with pytest.raises(UsageError, match=r"reward 'hooked' is taken by package one\.py"):
        load_registry([], read_given([lay(HOOKED, "one.py"), lay(HOOKED, "two.py")]))


def test_name_of_a_file_has_to_be_one(lay):
    """What users would have to type."""
    with pytest.raises(UsageError, match="its name 'my reward' must be lower-case"):
        load_registry([], read_given([lay(name="My Reward.py")]))


@dataclasses.dataclass(frozen=True)
class Mine:
    """A reward that this module holds."""

    k: float = 1.0

    def initial_carry(self, begin_distance):
        """Nothing."""
        return ()

    def __call__(self, carry, sample):
        """Some."""
        return carry, self.k * sample.distance


def test_class_is_known_by_its_module():
    """Given as the class or as text; its kind is read off."""
    target = "harness_plugins.rewards.arp:Arp"
    (given,) = read_given([target])
    assert given == PluginClass("rewards", target)
    assert from_plain(tuple[Given, ...], to_plain([given])) == (given,)
    registry = load_registry([], [given])
    assert registry.get("rewards", "harness_plugins.rewards.arp/Arp").target == target


def test_class_that_no_worker_finds_is_refused():
    """With what to do instead."""

    class Local(Mine):
        pass

    with pytest.raises(UsageError, match=r"Local is defined inside a function.*plugins=\['my_reward\.py'\]"):
        class_given(Local, "rewards")
    Local.__module__ = "__main__"
    with pytest.raises(UsageError, match="is defined in a notebook or script"):
        class_given(Local, "rewards")


def test_class_of_another_kind_is_refused():
    """It says what that kind has."""
    with pytest.raises(UsageError, match="Mine has no open; a simulator has open"):
        class_given(Mine, "simulators")


def test_what_an_experiment_names_has_to_be_given(lay):
    """A file is not loaded because an experiment file names it; one of the same name will do."""
    given = read_given([lay()])
    need = {**given[0].need, "path": "/far/away/my_reward.py"}
    require_given([need, "other/my_reward.py"], given)
    with pytest.raises(UsageError, match=r"needs the plugin my_reward\.py \(SHA-256 \w{8}\): give --plugin /far/away"):
        require_given([need], ())
    with pytest.raises(UsageError, match="needs the plugin a:B: give --plugin a:B"):
        require_given([{"target": "a:B"}], given)
    with pytest.raises(UsageError, match="names nothing: write the path of a file"):
        require_given([{"name": "my_reward"}], given)


def test_flags_give_what_an_experiment_names(lay):
    """Files by their path, quoted for a shell; classes by module and name; nothing for what is no name."""
    (given,) = read_given([lay()])
    assert plugin_flags([given.need]) == f" --plugin {given.path}"
    assert plugin_flags(["my rewards/a.py", {"target": "a:B"}]) == " --plugin 'my rewards/a.py' --plugin a:B"
    assert plugin_flags(["a.py; rm x"]) == " --plugin 'a.py; rm x'"
    assert plugin_flags(None) == plugin_flags([5, {}]) == plugin_flags(5) == ""
