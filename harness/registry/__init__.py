"""From a typed name to the object that a plugin registered under it."""

from typing import TYPE_CHECKING, Any

from harness.face import look_up

if TYPE_CHECKING:
    from harness.registry.choice import Choice, build_defaults, choose, parse, split_list
    from harness.registry.given import Given, given_from_json, given_to_json, read_given, require_given, split_measures
    from harness.registry.names import did_you_mean, unknown_name
    from harness.registry.parameters import build, parameters_of, values_of
    from harness.registry.registry import Plugin, Registry, load_registry
    from harness.registry.sources import fingerprint, source_hash
    from harness.registry.spec import OURS, Spec
    from harness.registry.toml_file import read_toml

__all__ = [
    "OURS",
    "Choice",
    "Given",
    "Plugin",
    "Registry",
    "Spec",
    "build",
    "build_defaults",
    "choose",
    "did_you_mean",
    "fingerprint",
    "given_from_json",
    "given_to_json",
    "load_registry",
    "parameters_of",
    "parse",
    "read_given",
    "read_toml",
    "require_given",
    "source_hash",
    "split_list",
    "split_measures",
    "unknown_name",
    "values_of",
]

_HOMES = {
    "choice": "Choice build_defaults choose parse split_list",
    "given": "Given given_from_json given_to_json read_given require_given split_measures",
    "names": "did_you_mean unknown_name",
    "parameters": "build parameters_of values_of",
    "registry": "Plugin Registry load_registry",
    "sources": "fingerprint source_hash",
    "spec": "OURS Spec",
    "toml_file": "read_toml",
}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)
