"""From a typed name to the object that a plugin registered under it."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.registry.choice import (
        Choice as Choice,
        Registry as Registry,
        build_defaults as build_defaults,
        choose as choose,
        parse as parse,
        split_list as split_list,
    )
    from harness.registry.given import (
        read_given as read_given,
        require_given as require_given,
        split_measures as split_measures,
    )
    from harness.registry.members import build as build, parameters_of as parameters_of, values_of as values_of
    from harness.registry.registry import load_registry as load_registry
    from harness.registry.sources import fingerprint as fingerprint, source_hash as source_hash
    from harness.registry.spec import (
        OURS as OURS,
        Spec as Spec,
        did_you_mean as did_you_mean,
        unknown_name as unknown_name,
    )
    from harness.registry.toml_file import read_toml as read_toml
else:
    __all__, __getattr__ = face_of(__name__)
