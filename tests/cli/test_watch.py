import json
import shutil
import threading
from http.client import HTTPConnection

import pytest

from harness.record import Store
from harness_plugins.audit import write_certificate
from harness_plugins.watch.trainings import source_of
from harness_plugins.watch.watch import HOST, Pages, open_server, pages_of
from tests.plugins.audit.search.certified import certificate_of
from tests.refusals import refused

ALL = 2
"""Trainings of an experiment with one seed."""


@pytest.fixture
def experiment(finished, tmp_path):
    """The folder of a finished experiment."""
    return tmp_path / finished(seeds=1)


@pytest.fixture
def get(experiment):
    """Ask the server of the experiment for a path; gets status and text."""
    with open_server(Pages(experiment), 0) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()

        def ask(path, host=None):
            connection = HTTPConnection(HOST, server.server_port)
            connection.request("GET", path, headers={"Host": host or f"{HOST}:{server.server_port}"})
            answer = connection.getresponse()
            text = answer.read().decode()
            connection.close()
            return answer.status, text

        yield ask
        server.shutdown()
        thread.join()


def test_the_page_shows_the_episodes(get):
    """With the replay and how many cells are done."""
    status, text = get("/")
    assert status == 200
    assert 'id="replay-player"' in text
    assert f"{ALL} of {ALL} trainings done." in text


def test_the_page_tells_when_more_cells_ended(get, experiment):
    """What it asks for every second is another when a cell's folder is there."""
    before = json.loads(get("/live")[1])
    shutil.rmtree(next((experiment / "cells").iterdir()))
    after = json.loads(get("/live")[1])
    assert (before["done"], after["done"]) == (ALL, ALL - 1)
    assert f"{ALL - 1} of {ALL} trainings done, 1 waiting." in after["news"]
    assert f"{ALL - 1} of {ALL} trainings done" in get("/")[1]


def test_results_are_asked_for_when_trainings_ended(get):
    """The answers so far, and what plays the episodes."""
    told = json.loads(get("/results")[1])
    assert "DIFFERENCE" in told["answers"]
    assert 'id="replay-player"' in told["replay"]
    assert told["script"]
    assert told["style"]


def test_watching_writes_nothing(get, experiment):
    """Into the folder, whatever is asked for."""
    before = contents(experiment)
    for path in ("/", "/live", "/results"):
        assert get(path)[0] == 200
    assert contents(experiment) == before


def contents(folder):
    """Every file in a folder, by name: when it was changed, and how long it is."""
    return {path: (path.stat().st_mtime_ns, path.stat().st_size) for path in sorted(folder.rglob("*"))}


def test_the_page_is_a_file(harness, experiment, tmp_path):
    """With all that there is by now, and without asking anybody for more."""
    assert harness("watch", experiment, "--html", tmp_path / "page.html").status == 0
    text = (tmp_path / "page.html").read_text()
    assert f"{ALL} of {ALL} trainings done." in text
    assert 'id="replay-player"' in text
    assert "fetch(" not in text


def test_nothing_else_is_served(get):
    """No file of the folder, and nothing to a page of elsewhere that has this machine asked by another name."""
    assert get("/plan.json")[0] == 404
    assert get("/", host="evil.example:80")[0] == 404


def test_a_taken_port_is_refused(experiment):
    """The message says what to do."""
    pages = Pages(experiment)
    with open_server(pages, 0) as server, refused("Give another"):
        open_server(pages, server.server_port)


def test_a_folder_in_another_alphabet_is_named(experiment, tmp_path):
    """Where it cannot be read any more: the page says so, though no status line can."""
    experiment.rename(tmp_path / "опыт")
    pages = Pages(tmp_path / "опыт")
    shutil.rmtree(tmp_path / "опыт")
    with open_server(pages, 0) as server:
        thread = threading.Thread(target=server.handle_request)
        thread.start()
        connection = HTTPConnection(HOST, server.server_port, timeout=60)
        connection.request("GET", "/")
        answer = connection.getresponse()
        told = answer.read().decode()
        connection.close()
        thread.join()
    assert answer.status == 500
    assert "опыт" in told


@pytest.mark.parametrize(("error", "lines"), [(ConnectionResetError(), 0), (BrokenPipeError(), 0), (KeyError("x"), 1)])
def test_a_client_that_leaves_is_no_error(experiment, capsys, error, lines):
    """A browser does that whenever a page is closed: nothing is printed; of what nobody foresaw a line."""
    with open_server(Pages(experiment), 0) as server:
        try:
            raise error
        except Exception:
            server.handle_error(None, None)
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", lines)


def test_a_folder_that_is_gone_is_called_gone(get, experiment):
    """On the page, while the server goes on."""
    shutil.rmtree(experiment)
    status, text = get("/")
    assert status == 500
    assert "No folder" in text
    assert get("/live")[0] == 500


def test_certificates_are_shown(certificates):
    """Of a folder and of one file; no file of the folder is served, whatever it is called."""
    (certificates / "index.html").write_text("forged")
    for path in (certificates, certificates / "near-failure.json"):
        pages = pages_of(path)
        assert "What a cheat would do: line" in pages.page()
        assert "forged" not in pages.page()
        assert pages.live() == "{}"


def test_certificates_that_are_gone_are_told(certificates):
    """In a line."""
    pages = pages_of(certificates)
    (certificates / "near-failure.json").unlink()
    with refused("has no certificate any more"):
        pages.page()


def test_a_damaged_certificate_is_one_line(harness, certificates):
    """As any damaged file is."""
    (certificates / "near-failure.json").write_text("{}")
    answer = harness("watch", certificates / "near-failure.json", "--no-browser")
    assert answer.status == 1
    assert len(answer.err.splitlines()) == 1


@pytest.fixture
def certificates(tmp_path):
    """A folder with one."""
    (tmp_path / "cheats").mkdir()
    write_certificate(certificate_of(), tmp_path / "cheats/near-failure.json")
    return tmp_path / "cheats"


def test_a_run_serves_its_page(harness, quick, monkeypatch, tmp_path):
    """As long as it goes on; it opens the page, and says how to see it again."""
    seen = []

    def look(address):
        connection = HTTPConnection(HOST, int(address.rstrip("/").rpartition(":")[2]), timeout=60)
        connection.request("GET", "/live")
        seen.append(json.loads(connection.getresponse().read()))
        connection.close()

    monkeypatch.setattr("webbrowser.open", look)
    answer = harness("run --reward arp --seeds 1 --out watched --watch", *quick)
    assert answer.status == 0
    assert seen[0]["news"].startswith(f"0 of {ALL} trainings done, {ALL} waiting.")
    assert "Live page: http://127.0.0.1:" in answer.err
    assert "harness watch watched" in answer.err
    with pytest.raises(ConnectionRefusedError):
        look(answer.err.partition("Live page: ")[2].partition("\n")[0])


def test_a_running_training_is_told_by_its_trace(experiment):
    """As long as a run uses the folder; of one that was killed the rows are shown that it had written."""
    (cell, *_) = sorted((experiment / "cells").iterdir())
    partial = cell.with_name(f".{cell.name}.partial")
    cell.rename(partial)
    (partial / "manifest.json").unlink()
    (partial / "evaluation.parquet").replace(partial / "trace.parquet")
    (experiment / "running.json").write_text(json.dumps({cell.name: {"started": 0.0, "steps": 7}}))
    source = source_of(experiment)
    assert "1 stopped. No run is using the folder" in source.look().news
    with Store(experiment).locked():
        shown = source.look()
    (running,) = [it for it in shown.trainings if it.state == "running"]
    assert (running.steps, running.asked) == (7, 12)
    assert running.blocks
    assert "1 running." in shown.news
