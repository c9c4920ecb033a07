import json
import shutil
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from functools import partial
from http.client import HTTPConnection

import pytest

from harness.record import Store
from harness_plugins.audit import write_certificate
from harness_plugins.watch import trainings
from harness_plugins.watch.serving import HOST, serving
from harness_plugins.watch.trainings import ExperimentSource, source_of
from harness_plugins.watch.watch import pages_of, served
from tests.plugins.audit.search.certified import certificate_of
from tests.refusals import refused

ALL = 2
"""Trainings of an experiment with one seed."""


@pytest.fixture
def experiment(finished, tmp_path):
    """The folder of a finished experiment."""
    return tmp_path / finished(seeds=1)


@pytest.fixture(autouse=True)
def looked_each_time(monkeypatch):
    """What was made is made again for the next who asks."""
    monkeypatch.setattr("harness_plugins.watch.serving.EVERY", 0.0)
    monkeypatch.setattr("harness_plugins.watch.watch.REST", 0.0)


@pytest.fixture
def get(experiment):
    """Ask the server of the experiment for a path; gets status and text."""
    with served(experiment) as address:
        yield partial(answer_of, address)


def answer_of(address, path="/", host=None):
    """Status and text of what a server gives."""
    connection = HTTPConnection(HOST, port_of(address), timeout=60)
    connection.request("GET", path, headers={"Host": host} if host else {})
    answer = connection.getresponse()
    text = answer.read().decode()
    connection.close()
    return answer.status, text


def port_of(address):
    """The port of an address."""
    return int(address.rstrip("/").rpartition(":")[2])


def test_the_page_shows_the_episodes(get):
    """With the replay and how many cells are done, once results were read; a page does not wait long for them."""
    get("/results")
    status, text = get("/")
    assert status == 200
    assert 'id="replay-player"' in text
    assert f"{ALL} of {ALL} trainings done." in text


def test_the_page_tells_when_more_cells_ended(get, experiment):
    """What it asks for every second is another when a cell's folder is there, and again when results of it are."""
    get("/results")
    before = json.loads(get("/live")[1])
    shutil.rmtree(next((experiment / "cells").iterdir()))
    assert f"{ALL - 1} of {ALL} trainings done, 1 waiting." in json.loads(get("/live")[1])["news"]
    get("/results")
    assert (before["done"], json.loads(get("/live")[1])["done"]) == (ALL, ALL - 1)
    assert f"{ALL - 1} of {ALL} trainings done" in get("/")[1]


def test_results_are_read_without_being_asked_for(get):
    """Whoever looks has them read; until they are there a page is told of none."""
    deadline = time.monotonic() + 60
    while json.loads(get("/live")[1])["done"] != ALL:
        assert time.monotonic() < deadline


def test_results_are_asked_for_when_trainings_ended(get):
    """The answers so far, and what plays the episodes."""
    told = json.loads(get("/results")[1])
    assert "DIFFERENCE" in told["answers"]
    assert 'id="replay-player"' in told["html"]
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
    with served(experiment) as address, refused("Give another"), served(experiment, port_of(address)):
        pass


def test_a_folder_in_another_alphabet_is_named(experiment, tmp_path):
    """Where it cannot be read any more: the page says so, though no status line can."""
    folder = experiment.rename(tmp_path / "опыт")
    with served(folder) as address:
        shutil.rmtree(folder)
        status, told = answer_of(address)
    assert status == 500
    assert "опыт" in told


def test_twenty_browsers_have_one_look(experiment, monkeypatch):
    """However often they ask within a second; nothing of a cell is read again that is what it was."""
    monkeypatch.setattr("harness_plugins.watch.serving.EVERY", 60.0)
    looks, look = [], ExperimentSource.look
    monkeypatch.setattr(ExperimentSource, "look", lambda source: looks.append(source) or look(source))
    with served(experiment) as address, ThreadPoolExecutor(20) as browsers:
        told = {*browsers.map(partial(answer_of, address), ["/live"] * 60)}
    assert [status for status, _ in told] == [200]
    assert len(looks) == 1


def test_a_look_reads_what_changed(experiment, monkeypatch):
    """No manifest that is the one it was, nor the plan; one that was written anew is read."""
    read, reader = [], trainings.read_manifest
    monkeypatch.setattr(trainings, "read_manifest", lambda folder: read.append(folder.name) or reader(folder))
    source = source_of(experiment)
    assert source.look() == source.look()
    assert len(read) == ALL
    manifest = next((experiment / "cells").iterdir()) / "manifest.json"
    manifest.write_text("{}")
    assert "1 damaged" in source.look().news
    assert len(read) == ALL + 1


def test_who_is_slow_holds_no_thread():
    """One that does not finish its question, or does not read the answer; others are served meanwhile."""
    routes = {"/": lambda: "x" * 2**25, "/live": lambda: "{}"}
    with serving(routes, 0) as address, ExitStack() as slow:
        before = threading.active_count()
        for asked in (b"GET / HTTP/1.1\r\nHost: localhost:1\r\n\r\n", b"GET / HT") * 10:
            client = slow.enter_context(socket.create_connection((HOST, port_of(address))))
            client.sendall(asked)
            assert client.recv(1) if asked.endswith(b"\n") else True
        assert answer_of(address, "/live") == (200, "{}")
        assert threading.active_count() == before


@pytest.mark.parametrize(("stays", "lines"), [(False, 0), (True, 1)])
def test_what_nobody_foresaw_is_a_line(capsys, stays, lines):
    """A client that leaves is no error: a browser does that whenever a page is closed."""
    routes = {"/": lambda: {}["x"] if stays else "x" * 2**25, "/live": lambda: "{}"}
    with serving(routes, 0) as address, socket.create_connection((HOST, port_of(address))) as client:
        client.sendall(b"GET / HTTP/1.1\r\nHost: localhost:1\r\n\r\n")
        client.recv(1)
        client.close()
        assert answer_of(address, "/live") == (200, "{}")
    assert capsys.readouterr().err.count("\n") == lines


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
        assert [*pages] == ["/"]
        assert "What a cheat would do: line" in pages["/"]()
        assert "forged" not in pages["/"]()


def test_certificates_that_are_gone_are_told(certificates):
    """In a line."""
    pages = pages_of(certificates)
    (certificates / "near-failure.json").unlink()
    with refused("has no certificate any more"):
        pages["/"]()


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
        seen.append(json.loads(answer_of(address, "/live")[1]))

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
