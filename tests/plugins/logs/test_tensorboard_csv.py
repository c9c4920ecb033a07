"""Curves as TensorBoard's own page exports them."""

import pytest

from tests.plugins.logs.reading import Reader

read = Reader("table", "run-base-tag-rollout_ep_rew_mean.csv")


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
    log = read(read.written(tmp_path, text))
    told = [line.split(",") for line in text.splitlines()[1:]]
    assert len(log) == len(told) == 1000
    assert log["time"].tolist() == [int(step) for _, step, _ in told]
    assert log["reward/recorded"] == pytest.approx([float(value) for *_, value in told], rel=1e-6)
    assert "a sample of at most 1,000 points" in log.facts.thinned
