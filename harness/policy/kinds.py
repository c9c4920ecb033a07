"""Every kind of policy that a card may name, and a saved policy of any of them."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from harness.errors import HarnessError, SchemaError
from harness.policy.discrete import Categorical, Greedy, UniformChoice
from harness.policy.policy import Deterministic, Gaussian, Policy, SquashedGaussian, Uniform, read_folder
from harness.text import one_line


def every_kind() -> Iterator[type[Policy]]:
    """Every kind; a new one is a word here. An arm's kinematics come last, since to look at them loads arms."""
    yield from (SquashedGaussian, Gaussian, Deterministic, Greedy, Categorical, Uniform, UniformChoice)
    from harness.policy.inverse_kinematics import InverseKinematics

    yield InverseKinematics


def kind_named(name: str) -> type[Policy]:
    """The kind of that name.

    Raises:
        ValueError: There is none; names those that there are.
    """
    for kind in every_kind():
        if kind.kind == name:
            return kind
    raise ValueError(f"no kind {name!r}; there is: {', '.join(kind.kind for kind in every_kind())}")


def load_policy(folder: Path) -> Policy:
    """The policy that `Policy.save` wrote, of whatever kind.

    Raises:
        SchemaError: The folder holds no policy of a format that this version reads.
    """
    try:
        card, weights = read_folder(folder)
        policy = kind_named(card["kind"]).from_card(card, weights)
        _require_told(card, policy)
    except HarnessError:
        raise
    except KeyError as error:
        raise SchemaError(f"{folder} holds no readable policy: {error} is missing") from error
    except Exception as error:  # bytes of anybody: any exception of numpy, safetensors and Python's numbers
        raise SchemaError(f"{folder} holds no readable policy: {one_line(str(error))}") from error
    return policy


def _require_told(card: Mapping[str, Any], policy: Policy) -> None:
    """See that the card tells of these arrays and not of others: it is what people read.

    Raises:
        ValueError: It does not.
    """
    for name, value in json.loads(json.dumps(policy.card())).items():
        if name in card and card[name] != value:
            raise ValueError(f"the card tells {name} {card[name]!r}, and its arrays have {value!r}")
