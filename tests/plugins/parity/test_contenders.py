"""Which simulators are compared, and in which order."""

from dataclasses import replace

import pytest

from harness.errors import PluginError
from harness.registry import Registry, Spec
from harness_plugins.parity import Missing, choose_contenders
from tests.refusals import refused


def spec(name, target="harness_plugins.kit:IdealSimulator", requires=(), plugin="toys"):
    """One that is registered."""
    return Spec("simulators", name, target, "", requires, "extra" if requires else None, plugin, "toy-arm")


def registry(*specs):
    """These and nothing else."""
    found = Registry()
    for one in specs:
        found.specs.setdefault(("simulators", one.name), []).append(one)
    return found


THREE = registry(spec("ideal"), spec("mujoco"), spec("zeta"))


def test_the_reference_comes_first(subtests):
    """The one that was named, or else mujoco, or else the first; a named one is taken in."""
    for given, reference, order in [
        ([], None, ["mujoco", "ideal", "zeta"]),
        (["zeta,ideal"], None, ["zeta", "ideal"]),
        (["zeta", "mujoco"], None, ["mujoco", "zeta"]),
        (["ideal,mujoco"], "ideal", ["ideal", "mujoco"]),
        (["ideal,mujoco"], "zeta", ["zeta", "ideal", "mujoco"]),
        ([], "zeta", ["zeta", "ideal", "mujoco"]),
    ]:
        with subtests.test(given=given):
            contenders = choose_contenders(THREE, given, reference)
            assert list(contenders.simulators) == order
            assert contenders.reference == order[0]


def test_parameters_make_another_simulator(toys):
    """One simulator at several settings; they come in the given order, comma or not."""
    pytest.importorskip("mujoco")
    contenders = choose_contenders(toys, ["mujoco:substeps=40,threads=2,mujoco", "ideal"], None)
    assert list(contenders.simulators) == ["mujoco", "mujoco:substeps=40,threads=2", "ideal"]
    assert contenders.simulators["mujoco:substeps=40,threads=2"].substeps == 40


def test_what_is_not_installed_is_listed_with_its_extra():
    """By default it is left out and told; whoever names simulators is not told of others."""
    both = registry(spec("ideal"), spec("distant", requires=("no_such_engine",)))
    contenders = choose_contenders(both, [], None)
    assert list(contenders.simulators) == ["ideal"]
    assert contenders.missing == (Missing("distant", "extra", "pip install 'toy-arm[extra]'"),)
    assert choose_contenders(both, ["ideal"], None).missing == ()


def test_a_named_one_that_is_not_installed_is_a_usage_error():
    """With the remedy."""
    with refused(r"needs no_such_engine: pip install 'toy-arm\[extra\]'"):
        choose_contenders(registry(spec("distant", requires=("no_such_engine",))), ["distant"], None)


def test_a_broken_plugin_costs_its_simulator_alone():
    """Unless it is named: then it is what was asked for."""
    both = registry(spec("ideal"), spec("broken", target="harness_plugins.kit:Nothing"))
    assert "harness_plugins.kit:Nothing" in choose_contenders(both, [], None).simulators["broken"].reason
    with pytest.raises(PluginError):
        choose_contenders(both, ["broken"], None)


def test_a_name_that_two_plugins_claim_stands_under_both_qualified_names():
    """And the plain name is a usage error that names them."""
    both = registry(spec("ideal"), spec("twin"), replace(spec("twin"), distribution="others"))
    assert list(choose_contenders(both, [], None).simulators) == ["ideal", "others/twin", "toy-arm/twin"]
    with pytest.raises(PluginError, match="write toy-arm/twin or others/twin"):
        choose_contenders(both, ["twin"], None)


@pytest.mark.parametrize(
    ("found", "given", "told"),
    [
        (THREE, ["ideal,ideal"], "'ideal' twice"),
        (THREE, ["idea"], "Did you mean 'ideal'"),
        (registry(), [], "No simulator is installed"),
    ],
)
def test_what_cannot_be_compared_is_told(found, given, told):
    """A name twice, an unknown name, nothing at all."""
    with refused(told):
        choose_contenders(found, given, None)
