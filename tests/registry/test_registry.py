"""Entry points in, specs out: each hook, and each way in which a plugin can be broken."""

import shutil
import sys
from importlib.metadata import EntryPoint, metadata
from typing import NamedTuple

import pytest

from harness import load_registry
from harness.errors import PluginError, UsageError
from harness.hookspecs import KINDS
from harness.registry import OURS, Spec, did_you_mean, registry as module, unknown_name
from harness.registry.registry import VARIABLE, Wanted, installed

ONE_OF_EACH = "import harness\n" + "".join(
    f"@harness.hookimpl\ndef register_{kind}(register):\n"
    f"    register('my-{kind}', 'json.decoder:JSONDecoder', summary='a {kind}')\n"
    for kind in KINDS
)


def _plugin_with(body, hook="register_rewards(register)"):
    return f"import harness\n@harness.hookimpl\ndef {hook}:\n    {body}\n"


def _reward(name="mine", target="json.decoder:JSONDecoder", more=""):
    return _plugin_with(f"register({name!r}, {target!r}, summary='a reward'{more})")


def _only(registry):
    assert len(registry.plugins) == 1
    return registry.plugins[0]


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_hook_registers_is_of_its_kind_alone(write_plugin, kind):
    """Each kind has a hook of its name."""
    import json.decoder

    registry = load_registry([write_plugin(ONE_OF_EACH, "mine")])
    spec = registry.get(kind, f"my-{kind}")
    assert (spec.kind, spec.summary, spec.plugin) == (kind, f"a {kind}", "mine")
    assert spec.load() is json.decoder.JSONDecoder
    assert registry.names(kind) == [f"my-{kind}"]


def test_plugin_says_what_it_registered(write_plugin):
    """The record of a plugin that works lists each kind and name."""
    plugin = _only(load_registry([write_plugin(_reward(), "mine")]))
    assert (plugin.name, plugin.status, plugin.reason, plugin.registered) == ("mine", "ok", "", ("reward mine",))


def test_third_party_distribution_comes_in_by_the_same_door(toys):
    """An installed package is found by its entry point, and known by its distribution and version."""
    (plugin,) = [plugin for plugin in toys.plugins if plugin.name == "toys"]
    assert (plugin.distribution, plugin.version, plugin.module, plugin.status) == ("toy-arm", "1.0", "toy_arm", "ok")
    assert toys.get("simulators", "ideal").distribution == "toy-arm"


def test_built_in_plugins_are_all_fine(monkeypatch):
    """What this distribution brings loads without a complaint, and no name is claimed twice."""
    monkeypatch.delenv("HARNESS_PLUGINS", raising=False)
    registry = load_registry()
    ours = [plugin for plugin in registry.plugins if plugin.distribution == "fd100-harness"]
    assert {plugin.status for plugin in ours} == {"ok"}
    assert registry.conflicts() == []


def test_built_in_names_that_take_a_library_name_an_extra_that_exists():
    """What `pip install 'fd100-harness[extra]'` asks for is an extra of this distribution."""
    ours = [spec for specs in load_registry().specs.values() for spec in specs if spec.distribution == "fd100-harness"]
    extras = {spec.name: spec.extra for spec in ours if spec.requires}
    assert {"sb3-sac": "sb3", "mujoco": "mujoco"}.items() <= extras.items()
    assert set(extras.values()) <= set(metadata("fd100-harness").get_all("Provides-Extra"))


def test_targets_are_not_imported_before_they_are_loaded(write_plugin, tmp_path):
    """Loading the registry imports the light module alone; loading a spec imports its target."""
    (tmp_path / "heavy_engine_of_a_test.py").write_text("class Engine: ...\n")
    registry = load_registry([write_plugin(_reward(target="heavy_engine_of_a_test:Engine"), "mine")])
    assert "heavy_engine_of_a_test" not in sys.modules
    engine = registry.get("rewards", "mine").load()
    assert engine is sys.modules["heavy_engine_of_a_test"].Engine


BROKEN = {
    "raises at import": ("raise RuntimeError('no\\nluck')", "RuntimeError: no luck"),
    "does not parse": ("def", "SyntaxError: invalid syntax"),
    "leaves at import": ("import sys; sys.exit(3)", "SystemExit: 3"),
    "misses a module": ("import no_such_module_here", "ModuleNotFoundError: No module named 'no_such_module_here'"),
    "raises in a hook": (_plugin_with("raise RuntimeError('hooked')"), "RuntimeError: hooked"),
    "leaves in a hook": (_plugin_with("raise SystemExit"), "SystemExit"),
    "registers a bad name": (_reward("My Reward"), "name 'My Reward' must be lower-case"),
    "registers no name": (_reward(""), "name '' must be lower-case"),
    "registers a colon": (_reward("a:b"), "name 'a:b' must be lower-case"),
    "registers a bad target": (_reward(target="json.decoder"), "'json.decoder' of 'mine' must be 'module:attribute'"),
    "requires a text": (_reward(more=", requires='numpy'"), "must be a list of modules, not a string"),
    "forgets the summary": (_plugin_with("register('mine', 'a:b')"), "'summary'"),
}


def test_name_registered_before_a_hook_broke_is_not_kept(write_plugin):
    """A plugin is loaded as a whole or not at all."""
    source = _reward("half") + "    raise RuntimeError\n"
    assert load_registry([write_plugin(source, "broken")]).names("rewards") == []


INCOMPATIBLE = {
    "unknown hook": (
        _plugin_with("pass", "register_rewrads(register)"),
        "there is no hook register_rewrads. Did you mean 'register_rewards'?",
    ),
    "wrong signature": (
        _plugin_with("pass", "register_rewards(registrar)"),
        "register_rewards(registrar) cannot be called: its one argument has to be named 'register'",
    ),
    "newer interfaces": ("harness_api = 3\n" + _reward(), "written for harness_api 3, this is 2"),
    "interfaces that never were": ("harness_api = [1]\n" + _reward(), "written for harness_api [1], this is 2"),
    "earlier interfaces": (
        "harness_api = 1\n" + _reward(),
        "written for harness_api 1, this is 2: run its tests",
    ),
    "no hook": ("import harness\n", "implements no hook: mark its functions with"),
    "strange hook": (
        _plugin_with("pass", "paint(register)"),
        "there is no hook paint. There is: register_simulators, ",
    ),
    "unmarked hook": (
        _plugin_with("pass", "register_metrics(register)") + "def register_rewards(register): ...\n",
        "register_rewards is not marked: write @harness.hookimpl above it",
    ),
}


@pytest.mark.parametrize(
    ("status", "source", "reason"),
    [("broken", *it) for it in BROKEN.values()] + [("incompatible", *it) for it in INCOMPATIBLE.values()],
    ids=[*BROKEN, *INCOMPATIBLE],
)
def test_plugin_that_does_not_load_says_why_and_stops_no_other(write_plugin, status, source, reason):
    """In one line; nothing of it is registered, and its neighbours load."""
    names = ("after", "odd", "before")
    after, odd, before = (
        write_plugin(source if it == "odd" else _reward(it), it, entry=f"{at}-{it}")
        for at, it in zip("zma", names, strict=True)
    )
    registry = load_registry([after, odd, before])
    assert [plugin.status for plugin in registry.plugins] == ["ok", status, "ok"]
    assert reason in registry.plugins[1].reason
    assert "\n" not in registry.plugins[1].reason
    assert registry.names("rewards") == ["after", "before"]


def test_plugin_may_state_this_version_of_the_interfaces(write_plugin):
    """`harness_api = 2` loads, and there is nothing to remark; so does one that states none."""
    for stated in ("harness_api = 2\n", ""):
        plugin = _only(load_registry([write_plugin(stated + _reward(), f"mine{len(stated)}")]))
        assert plugin.status == "ok"


def test_module_named_by_two_entry_points_loads_once(write_plugin):
    """The second entry point is recorded as incompatible, and no name is claimed twice."""
    first = write_plugin(_reward(), "mine", entry="a")
    registry = load_registry([first, EntryPoint("b", first.value, "harness")])
    assert [plugin.status for plugin in registry.plugins] == ["ok", "incompatible"]
    assert registry.conflicts() == []


def test_name_claimed_twice_names_both_plugins(write_plugin):
    """Neither wins: using the name is an error that names both, and other names still work."""
    registry = load_registry(
        [write_plugin(_reward(), "one"), write_plugin(_reward(), "two"), write_plugin(_reward("other"), "three")]
    )
    with pytest.raises(PluginError, match=r"Reward 'mine' is claimed by the plugins 'one' \(.*\) and 'two' \(.*\)"):
        registry.get("rewards", "mine")
    assert len(registry.conflicts()) == 1
    assert registry.get("rewards", "other").plugin == "three"


def test_same_name_of_two_kinds_is_no_conflict(write_plugin):
    """A simulator and a reward may share a name."""
    simulator = _plugin_with("register('mine', 'a:b', summary='')", "register_simulators(register)")
    registry = load_registry([write_plugin(_reward(), "one"), write_plugin(simulator, "two")])
    assert registry.conflicts() == []


@pytest.mark.parametrize(
    ("value", "statuses"), [("", ["off", "off"]), ("two", ["off", "ok"]), (" one , two ", ["ok", "ok"])]
)
def test_environment_variable_restricts_what_loads(write_plugin, monkeypatch, value, statuses):
    """HARNESS_PLUGINS names the plugins to load; the others are off, and an empty list loads none."""
    points = [write_plugin(_reward("first"), "one"), write_plugin(_reward("second"), "two")]
    monkeypatch.setenv("HARNESS_PLUGINS", value)
    registry = load_registry(points)
    assert [plugin.status for plugin in registry.plugins] == statuses
    assert len(registry.names("rewards")) == statuses.count("ok")


def test_plugin_that_is_off_is_not_imported(write_plugin, monkeypatch):
    """A plugin that HARNESS_PLUGINS leaves out cannot do harm at import."""
    point = write_plugin("raise SystemExit", "one")
    monkeypatch.setenv("HARNESS_PLUGINS", "")
    assert _only(load_registry([point])).status == "off"
    assert point.module not in sys.modules


def _spec(requires=(), extra=None, target="json.decoder:JSONDecoder"):
    return Spec("simulators", "mine", target, "", requires, extra, "one", "a-package")


def test_missing_library_names_the_extra():
    """The message says what is missing and the line that installs it."""
    spec = _spec(("numpy", "no_such_engine"), "engine")
    with pytest.raises(UsageError, match=r"Simulator 'mine' needs no_such_engine: pip install 'a-package\[engine\]'"):
        spec.load()


def test_missing_library_without_an_extra_names_the_library():
    """Where the plugin names no extra, the missing modules themselves are what to install."""
    assert _spec(("no_such_engine", "no_such.wheel")).remedy == "pip install no_such_engine no_such.wheel"


def test_library_that_is_there_is_not_missing():
    """What can be imported is not imported to find out."""
    assert _spec(("numpy", "antigravity")).missing == ()
    assert "antigravity" not in sys.modules


BAD_TARGETS = {
    "no module": ("no_such_module_here:Engine", "No module named"),
    "no attribute": ("json.decoder:Engine", "has no attribute 'Engine'"),
    "leaves": ("leaving_engine_of_a_test:Engine", "SystemExit: 4"),
}


@pytest.mark.parametrize(("target", "reason"), BAD_TARGETS.values(), ids=BAD_TARGETS)
def test_target_that_cannot_be_imported_names_its_plugin(tmp_path, monkeypatch, target, reason):
    """The error names plugin, distribution, target and what went wrong."""
    (tmp_path / "leaving_engine_of_a_test.py").write_text("raise SystemExit(4)")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(PluginError, match=rf"Plugin 'one' \(a-package\): {target} of simulator 'mine'.*{reason}"):
        _spec(target=target).load()


def test_unknown_name_offers_the_nearest(toys):
    """One line: what was given, what there is, the nearest match."""
    with pytest.raises(UsageError) as error:
        toys.get("algorithms", "wandr")
    assert str(error.value).startswith("No algorithm 'wandr'. There is: both, buttons, ")
    assert str(error.value).endswith(" Did you mean 'wander'?")


def test_unknown_name_among_none():
    """Where nothing is registered, the message says so."""
    assert unknown_name("reward", "arp", []) == "No reward 'arp'. There is: none."


def test_far_name_has_no_near_match():
    """Nothing is offered that does not look alike."""
    assert did_you_mean("mujoco", ["sac", "spg"]) == ""


class Dist(NamedTuple):
    """What the loading asks of a distribution."""

    name: str
    version: str


def _points(write_plugin, **distributions):
    """Plugins that all register the reward 'mine', by entry point, each of its distribution."""
    found = []
    for entry, name in distributions.items():
        point = write_plugin(_reward(), entry)
        found.append(point._for(Dist(name, "1.0")))
    return found


def test_built_in_name_stays_the_built_in_one(write_plugin):
    """Whoever claims it too has the qualified name, and a line says so."""
    registry = load_registry(_points(write_plugin, one="fd100-harness", two="Clash_Algo"))
    assert registry.get("rewards", "mine").distribution == "fd100-harness"
    assert registry.get("rewards", "clash-algo/mine").plugin == "two"
    assert registry.names("rewards") == ["Clash_Algo/mine", "mine"]
    assert registry.conflicts() == [
        "Reward 'mine' is the built-in one. It is claimed by package Clash_Algo 1.0 too: write Clash_Algo/mine for that"
    ]


def _quick_under(write_plugin, distribution, name="quick-one", short="quick"):
    """The entry point of a reward with a short name."""
    source = _reward(name, more=f", short={short!r}" if short else "")
    point = write_plugin(source, distribution.replace("-", ""))
    return point._for(Dist(distribution, "1.0"))


def test_short_name_means_the_registered_one(write_plugin):
    """It can be typed, plainly and qualified; lists and records have the name."""
    registry = load_registry([_quick_under(write_plugin, OURS)])
    assert {registry.get("rewards", it).name for it in ("quick", "quick-one", f"{OURS}/quick")} == {"quick-one"}
    assert (registry.names("rewards"), registry.typed_names("rewards")) == (["quick-one"], ["quick", "quick-one"])
    assert registry.short_names("rewards") == {"quick": "quick-one"}
    assert [spec.name for spec in registry.all_specs()] == ["quick-one"]
    assert registry.kinds_of("quick") == ["rewards"]
    with pytest.raises(UsageError, match=r"There is: quick, quick-one\. Did you mean 'quick'"):
        registry.get("rewards", "quik")


def test_our_short_name_stays_ours(write_plugin):
    """A plugin of others with that name has the qualified one, and a line says so."""
    registry = load_registry([_quick_under(write_plugin, OURS), _quick_under(write_plugin, "other-algo", "quick", "")])
    assert registry.get("rewards", "quick").name == "quick-one"
    assert registry.get("rewards", "other-algo/quick").distribution == "other-algo"
    assert registry.names("rewards") == ["other-algo/quick", "quick-one"]
    assert registry.conflicts() == [
        "Reward 'quick' is the built-in one. It is claimed by package other-algo 1.0 too: "
        "write other-algo/quick for that"
    ]


def test_short_name_of_others_takes_no_name_of_ours(write_plugin):
    """The built-in one stays, and theirs has its own name."""
    registry = load_registry(
        [_quick_under(write_plugin, OURS, "mine", ""), _quick_under(write_plugin, "o-algo", short="mine")]
    )
    assert registry.get("rewards", "mine").distribution == OURS
    assert registry.short_names("rewards") == {}
    assert registry.names("rewards") == ["mine", "quick-one"]


def test_short_name_is_checked_as_a_name(write_plugin):
    """The plugin is broken, and the message says which name."""
    registry = load_registry([_quick_under(write_plugin, "other-algo", short="Not One")])
    assert "'Not One' must be lower-case" in _only(registry).reason


def test_sac_is_short_for_the_quick_learner():
    """And stable-baselines3's has a name of its own."""
    registry = load_registry()
    assert registry.get("algorithms", "sac").name == "sac-fast"
    assert registry.get("algorithms", "sb3-sac").modules == ("stable_baselines3", "torch")


def test_name_of_two_third_parties_is_told_with_both_qualified_names(write_plugin):
    """The plain name is an error, the qualified ones are not."""
    registry = load_registry(_points(write_plugin, one="one-algo", two="two-algo"))
    with pytest.raises(PluginError, match="write one-algo/mine or two-algo/mine, or leave one out"):
        registry.get("rewards", "mine")
    assert registry.get("rewards", "two-algo/mine").plugin == "two"
    assert registry.names("rewards") == ["one-algo/mine", "two-algo/mine"]


def test_name_that_one_distribution_claims_twice_cannot_be_qualified(write_plugin):
    """One of the plugins has to be left out."""
    registry = load_registry(_points(write_plugin, one="algo", two="algo"))
    assert registry.names("rewards") == []
    with pytest.raises(PluginError, match=r"\(algo 1\.0\): leave one out with HARNESS_PLUGINS=-two"):
        registry.get("rewards", "algo/mine")


def test_qualified_name_of_a_sole_claimant_is_its_plain_one(write_plugin):
    """Both find it, and the kinds of both are known."""
    registry = load_registry(_points(write_plugin, one="one-algo"))
    assert registry.get("rewards", "one-algo/mine") is registry.get("rewards", "mine")
    assert registry.kinds_of("one-algo/mine") == registry.kinds_of("mine") == ["rewards"]
    assert registry.kinds_of("two-algo/mine") == []
    with pytest.raises(UsageError, match="No reward 'two-algo/mine'"):
        registry.get("rewards", "two-algo/mine")


def test_unknown_name_tells_of_plugins_that_did_not_load(write_plugin):
    """The name may be theirs."""
    registry = load_registry([write_plugin("import harness\n", "empty"), write_plugin("raise OSError", "sick")])
    with pytest.raises(UsageError) as error:
        registry.get("rewards", "mine")
    assert "Not loaded: plugin 'empty' of empty_" in str(error.value)
    assert "is incompatible: implements no hook" in str(error.value)
    assert "is broken: OSError" in str(error.value)
    assert len(registry.complaints()) == 2


def test_module_of_a_package_is_looked_for_without_importing_the_package(tmp_path, monkeypatch):
    """It may stand in another folder than the package, as another distribution may bring it."""
    for folder, file in (("one", "__init__.py"), ("two", "extra.py")):
        (tmp_path / folder / "spread_out").mkdir(parents=True)
        (tmp_path / folder / "spread_out" / file).write_text("raise RuntimeError('imported')")
        monkeypatch.syspath_prepend(tmp_path / folder)
    required = ("spread_out.extra", "spread_out.none", "no_such_package.extra")
    assert _spec(required).missing == ("spread_out.none", "no_such_package.extra")


@pytest.fixture
def add(tmp_path, monkeypatch):
    """Install a package with one entry point of the group `seen`, in a folder that is searched from the start."""
    monkeypatch.syspath_prepend(tmp_path)

    def add_package(name):
        folder = tmp_path / f"{name}-1.0.dist-info"
        folder.mkdir()
        (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        (folder / "entry_points.txt").write_text(f"[seen]\n{name} = {name}\n[other]\n{name} = other\n")
        return folder

    return add_package


def _names():
    return sorted(point.name for point in installed("seen"))


def test_entry_points_of_a_group_are_found(add):
    """With the distribution that they are of; another group's are not."""
    assert installed("seen") == ()
    add("first")
    (found,) = installed("seen")
    assert (found.name, found.value, found.dist.name) == ("first", "first", "first")


def test_what_is_installed_meanwhile_is_found(add):
    """And what was removed is not: a notebook lives long."""
    first = add("first")
    assert _names() == ["first"]
    add("second")
    assert _names() == ["first", "second"]
    shutil.rmtree(first)
    assert _names() == ["second"]


def test_who_searches_elsewhere_finds_what_is_there(add, monkeypatch):
    """A folder that Python no longer searches counts no more."""
    add("first")
    assert _names() == ["first"]
    monkeypatch.setattr("sys.path", [])
    assert _names() == []


def test_distributions_are_read_once(add, monkeypatch):
    """As long as nothing changes: there may be hundreds."""
    add("first")
    asked = []
    monkeypatch.setattr(module, "entry_points", lambda group: asked.append(group) or ())
    for _ in range(3):
        installed("seen")
    assert asked == ["seen"]


def _loads(monkeypatch, value, *plugin):
    monkeypatch.delenv(VARIABLE, raising=False)
    if value is not None:
        monkeypatch.setenv(VARIABLE, value)
    return not Wanted.from_environment().why_off(*plugin)


@pytest.mark.parametrize(
    ("value", "loads"),
    [
        (None, True), ("", False), ("clash", True), ("other", False), ("-clash", False), ("-other", True),
        (" -other , -more ", True), ("other,-clash", False), ("clash,-clash", False), ("-clash-algo", False),
        ("-Clash_Algo/clash", False), ("clash-algo/clash", True), ("-other/clash", True),
    ],
)  # fmt: skip
def test_third_party_plugin(monkeypatch, value, loads):
    """By its entry point, its distribution or both; a minus leaves out, and wins."""
    assert _loads(monkeypatch, value, "clash", "Clash_Algo") == loads


@pytest.mark.parametrize(
    ("value", "loads"), [("", True), ("clash", True), ("-clash", True), ("-rewards", False), (f"-{OURS}/tasks", True)]
)
def test_built_in_plugin_stays_unless_it_is_left_out(monkeypatch, value, loads):
    """Whoever names one plugin does not lose the simulators."""
    assert _loads(monkeypatch, value, "rewards", OURS) == loads


def test_name_of_no_plugin_is_told(monkeypatch):
    """A mistyped one leaves nothing out."""
    monkeypatch.setenv(VARIABLE, "-clsh,one")
    told = Wanted.from_environment().unknown([("clash", "clash-algo"), ("one", "ones")])
    assert told == ["HARNESS_PLUGINS names 'clsh', which is no plugin. Did you mean 'clash'?"]
