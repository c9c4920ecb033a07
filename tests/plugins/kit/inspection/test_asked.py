"""What a check was asked for, on its way to another process."""

import json

from harness.files.plain import from_plain, to_plain
from harness_plugins.kit.inspection.finding import Asked, read_plugins
from tests.refusals import refused


def test_what_was_asked_for_survives_the_way_through_json(tmp_path):
    """With the text of a plugin file, and of the modules that lie beside it."""
    (tmp_path / "beside.py").write_text("FACTOR = 2\n")
    (tmp_path / "mine.py").write_text(
        "import beside\n\ndef mine(observation, action, next_observation, info):\n    ...\n"
    )
    files, classes = read_plugins([str(tmp_path / "mine.py"), "package.module:Class"])
    assert [name for name, _ in files[0].beside] == ["beside"]
    asked = Asked("mine", "reward", "fd100", files, classes)
    assert from_plain(Asked, json.loads(json.dumps(to_plain(asked)))) == asked


def test_class_is_not_imported():
    """That happens in the process that it may end."""
    assert read_plugins(["no_such_package:Class", "no_such_package:Class"]) == ((), ("no_such_package:Class",))


def test_file_that_is_not_there_is_refused(tmp_path):
    """Before any process is started."""
    with refused(r"mine\.py"):
        read_plugins([str(tmp_path / "mine.py")])
