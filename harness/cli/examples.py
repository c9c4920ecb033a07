"""What one may type: examples of every command, shown at the end of its help."""

from collections.abc import Mapping
from types import MappingProxyType

FIRST_STEPS = ("harness demo", "harness run --sim mujoco --algo sac")

EXAMPLES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "demo": ("harness demo", "harness demo --out my-first"),
        "run": (
            "harness run --sim mujoco --algo sac",
            "harness run --sim kinematic --algo ik --reward arp,scaled:factor=3 --seeds 3",
            "harness run --sim mujoco --algo sac --reward dense --until decided",
            "harness run experiment.toml --seeds 20 --out my-results --dry-run",
        ),
        "choose": (
            "harness choose --reward arp,dense,relative --sim mujoco --algo sac",
            "harness choose --plugin 'candidates/*.py' --task gymnasium:id=Pendulum-v1 --algo sac",
        ),
        "report": (
            "harness report my-results",
            "harness report my-results --details",
            "harness report my-results more-results",
            "harness report my-results --html page.html --summary records",
        ),
        "status": ("harness status my-results",),
        "eta": ("harness eta --baseline 'base/*.csv' --proposed 'k2/*.csv'", "harness eta recorded --plot page.html"),
        "score": ("harness score my-results --reward arp:k2=2 --all", "harness score runs.csv --reward sparse"),
        "verify": ("harness verify my-results", "harness verify my-results --repair"),
        "merge": ("harness merge from-one from-another --out all",),
        "describe": ("harness describe", "harness describe rewards", "harness describe sac:gamma=0.9"),
    }
)


def epilog_of(examples: tuple[str, ...], title: str = "Examples:") -> str:
    """The lines at the end of a help."""
    return "\n".join([title, *(f"  {example}" for example in examples)])
