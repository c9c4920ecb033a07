"""Curves as TensorBoard's own page exports them."""

import pytest

from harness.errors import UsageError
from tests.plugins.logs.reading import Reader

TEXT = "Wall time,Step,Value\r\n1700000000.5,2048,0.25\r\n1700000001.5,4096,0.5\r\n"

read = Reader("table")


def written(folder, name, text=TEXT):
    """A file with this text."""
    (folder / name).write_bytes(text.encode())
    return folder / name


@pytest.mark.filterwarnings("ignore:html5lib's sanitizer:DeprecationWarning")  # TensorBoard's page imports it
def test_what_the_page_itself_exports_is_read_and_said_to_be_a_sample(tmp_path):
    """Issue 4047 of TensorBoard: of 3,000 points the export has 1,000."""
    pytest.importorskip("tensorboard", reason="needs the extra tensorboard")
    from tensorboard.backend.event_processing.data_provider import MultiplexerDataProvider
    from tensorboard.backend.event_processing.plugin_event_multiplexer import EventMultiplexer
    from tensorboard.context import RequestContext
    from tensorboard.plugins.base_plugin import TBContext
    from tensorboard.plugins.scalar.scalars_plugin import OutputFormat, ScalarsPlugin
    from tensorboard.summary import Writer

    writer = Writer(str(tmp_path / "base"))
    for step in range(3000):
        writer.add_scalar("rollout/ep_rew_mean", step / 8, step)
    writer.close()
    multiplexer = EventMultiplexer(tensor_size_guidance={"scalars": 0}).AddRunsFromDirectory(str(tmp_path))
    multiplexer.Reload()
    plugin = ScalarsPlugin(TBContext(data_provider=MultiplexerDataProvider(multiplexer, str(tmp_path))))
    text, _ = plugin.scalars_impl(RequestContext(), "rollout/ep_rew_mean", "base", "", OutputFormat.CSV)
    log = read(written(tmp_path, "run-base-tag-rollout_ep_rew_mean.csv", text))
    told = [line.split(",") for line in text.splitlines()[1:]]
    assert len(log) == len(told) == 1000
    assert log["time"].tolist() == [int(step) for _, step, _ in told]
    assert log["reward/recorded"] == pytest.approx([float(value) for *_, value in told], rel=1e-6)
    assert "a sample of at most 1,000 points" in log.facts.thinned


def test_a_file_of_another_name_is_read_where_the_user_says_what_it_is(tmp_path):
    """Its columns do not tell."""
    path = written(tmp_path, "curve.csv")
    with pytest.raises(UsageError, match=r"say reward=NAME. It has: Wall time, Step, Value"):
        read(path)
    assert read(path, success="Value")["behaviour/success"].tolist() == [0.25, 0.5]
    assert read(path, reward="Value", per_step=1)["time"].tolist() == [2048, 4096]
