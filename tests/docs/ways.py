"""What is not executed of the snippets of the pages, and why not."""

from types import MappingProxyType

NOT_RUN = MappingProxyType(
    {
        "transfer": "starts a process for each policy; tests/plugins/transfer does it in one",
        "parity": "drives several simulators for seconds; tests/plugins/parity has short drives",
        "watch": "serves until it is stopped",
        "video": "draws for seconds; tests/cli/test_video.py has a short film",
        "audit": "takes seconds for each reward; tests/cli/test_audit.py",
        "check": "takes seconds to minutes; tests/contracts",
        "doctor": "tries to render in several processes; tests/cli/test_doctor.py",
    }
)
"""Commands that are parsed alone: name, flags, and the types of their values."""

NEEDS = MappingProxyType(
    {
        r"(?<!new-plugin )\bmy-(?!results|first)": "the package is not there; `make plugins` tries such ones",
        "cautious|steady|mesh-arm|pinocchio|sbx-sac": "the package is not installed: `make examples` does it",
        "fetch-reach|id=Ant-v5": "takes libraries that are in no lock; tests/experiment/environments has a toy",
        "airo_models": "a package of arms that is in no lock: `make arms` installs it",
        "slurm|ray:address": "takes a cluster",
        "SLURM_ARRAY|part-": "takes a shell; tests/docs/test_how_to.py does two jobs",
        "unity:|unity_player|extra unity": "takes a program and an old protobuf; tests/plugins/unity_player",
        "--screen": "takes seconds for each reward; tests/cli/test_choose.py",
        "--fail-on": "its status is the answer; tests/cli/test_fail_on.py",
        "cells/|CELL": "takes a trained policy; tests/plugins/commands",
        "--cells": "names cells of the reader's",
        "score pendulum|report pendulum": "takes a training; tests/experiment/environments/test_reward_files.py",
        "score own": "takes a training; tests/cli/test_score.py",
        "recorded|report runs": "takes the reader's recordings; tests/cli/test_eta.py, tests/results/recordings",
    }
)
"""Patterns of commands that are only parsed."""

HELD = MappingProxyType(
    {
        "docs/your-environment.md": "tests/test_your_environment.py",
        "docs/recording.md": "tests/test_your_environment.py",
        "docs/authoring.md": "tests/authoring/test_public_names.py",
        "docs/writing/": "tests/plugins/kit/test_pages.py, tests/plugins/tasks/test_writing_page.py",
        "docs/how-to/tune.md": "tests/docs/test_how_to.py",
        "docs/how-to/timings.md": "tests/docs/test_how_to.py",
        "docs/how-to/own-reward.md": "tests/cli/test_plugin_files.py; commands here use the file that it shows",
    }
)
"""Pages whose Python other tests hold."""

SKIPPED = MappingProxyType(
    {
        'pyarrow.parquet.read_table("curves.parquet")': "an excerpt: reads what `harness report --summary` wrote",
        'policy = load_policy(Path("results/runs/mine': "an excerpt: the folder is the reader's; tests/policy",
        "from harness_plugins.transfer.jobs import transfer": "the folder is the reader's; tests/plugins/transfer",
        'subprocess.check_output([sys.executable, "-m", "harness"': "the reader's folder; tests/cli/test_report.py",
        "RecordVideo(": "takes moviepy, which writes films; tests/env/test_single_env.py draws",
        "evaluate_policy(lambda it:": "trains; tests/test_your_environment.py runs it with fewer steps",
        "HerReplayBuffer": "trains for minutes; tests/env/test_goal_env.py",
    }
)
"""Python that is not executed, by a part of it."""
