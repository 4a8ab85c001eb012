"""Data sets downloaded once, from a server in this process, since tests need no network."""

import hashlib
import os
import shutil
import ssl
import subprocess
import sys
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest

from springpot.errors import DataError
from springpot_plugins.datasets import download, folders, springpot_datasets
from springpot_plugins.datasets.folders import read_manifest

CONTENT = b"f;Ks;Kl\n1;2;3\n2;3;4\n"
MANIFEST = """
summary = "a damper"
file = "raw.csv"
licence = "CC0"
[columns]
frequency = {{ from = "f", unit = "Hz" }}
storage = {{ from = "Ks", unit = "kN/m" }}
loss = {{ from = "Kl", unit = "kN/m" }}
[download]
url = "{url}"
sha256 = "{sha256}"
"""


class Server(ThreadingHTTPServer):
    """Answers with `content`, of which `sent` bytes arrive; counts the requests."""

    content, sent, requests, moved = CONTENT, None, 0, ""


class Handler(BaseHTTPRequestHandler):
    def do_GET(self):
        server = self.server
        server.requests += 1
        if self.path.startswith("/gone"):
            self.send_error(404)
            return
        if server.moved:
            self.send_response(302)
            self.send_header("Location", server.moved)
            self.end_headers()
            return
        self.send_response(200)
        self.send_header("Content-Length", str(len(server.content)))
        self.end_headers()
        self.wfile.write(server.content[: server.sent])

    def log_message(self, *arguments):
        """Say nothing."""


@pytest.fixture(scope="module")
def certificate(tmp_path_factory):
    """Of this machine, for two days."""
    program = shutil.which("openssl")
    if program is None:
        pytest.skip("no openssl to make a certificate with")
    folder = tmp_path_factory.mktemp("certificate")
    made = ["req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=127.0.0.1"]
    names = [
        "-addext",
        "subjectAltName=IP:127.0.0.1",
        "-keyout",
        str(folder / "key"),
        "-out",
        str(folder / "own"),
    ]
    subprocess.run([program, *made, *names], check=True, capture_output=True)
    return folder


@pytest.fixture
def server(tmp_path, monkeypatch, certificate):
    pytest.importorskip("pooch")
    monkeypatch.setenv("REQUESTS_CA_BUNDLE", str(certificate / "own"))
    monkeypatch.setenv(download.CACHE, str(tmp_path / "cache"))
    monkeypatch.setenv("NO_PROXY", "*")
    secure = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    secure.load_cert_chain(certificate / "own", certificate / "key")
    with Server(("127.0.0.1", 0), Handler) as running:
        running.socket = secure.wrap_socket(running.socket, server_side=True)
        thread = threading.Thread(target=running.serve_forever, daemon=True)
        thread.start()
        yield running
        running.shutdown()
        thread.join()


def manifest(server, file="raw.csv", content=CONTENT, text=MANIFEST):
    url = f"https://127.0.0.1:{server.server_port}/{file}"
    said = text.format(url=url, sha256=hashlib.sha256(content).hexdigest())
    return read_manifest(said, folders.NOWHERE / "my-damper", "manifest")


def left(tmp_path):
    """Files in the cache."""
    return [path for path in (tmp_path / "cache").rglob("*") if path.is_file()]


@pytest.mark.soak
def test_a_set_is_downloaded_once(server, tmp_path):
    dataset = manifest(server).dataset()
    assert dataset.unavailable == ""
    assert server.requests == 0, "nothing is fetched before it is used"
    for _ in range(2):
        np.testing.assert_array_equal(dataset.open().stiffness, [2 + 3j, 3 + 4j])
    assert server.requests == 1
    assert [path.name for path in left(tmp_path)] == ["raw.csv"]


def test_a_file_of_other_content_is_never_replaced(server, tmp_path):
    dataset = manifest(server).dataset()
    dataset.open()
    [copy] = left(tmp_path)
    copy.write_bytes(b"something of mine")
    assert "is not replaced; remove it" in complaint(dataset)
    assert copy.read_bytes() == b"something of mine"
    assert server.requests == 1
    copy.unlink()
    assert len(dataset.open()) == 2


def test_a_file_that_appears_during_the_download_is_not_replaced_either(
    server, tmp_path, monkeypatch
):
    put = download._put

    def late(draft, path):
        path.write_bytes(b"another's")
        put(draft, path)

    monkeypatch.setattr(download, "_put", late)
    assert "is not replaced" in complaint(manifest(server).dataset())
    assert [path.read_bytes() for path in left(tmp_path)] == [b"another's"]


def test_of_two_processes_that_fetch_a_file_at_once_both_have_it(server, tmp_path, monkeypatch):
    put = download._put

    def after_another(draft, path):
        put(draft, path)
        put(draft, path)

    monkeypatch.setattr(download, "_put", after_another)
    assert len(manifest(server).dataset().open()) == 2
    assert [path.read_bytes() for path in left(tmp_path)] == [CONTENT]


def test_a_file_that_another_process_puts_there_before_the_download_is_used(
    server, tmp_path, monkeypatch
):
    asked, exists = [], Path.exists

    def late(path, **options):
        """Between the first look and the next one it appears."""
        if path.name == "raw.csv" and not asked:
            asked.append(path)
            path.parent.mkdir(parents=True)
            path.write_bytes(CONTENT)
        return exists(path, **options)

    dataset = manifest(server).dataset()
    monkeypatch.setattr(Path, "exists", late)
    assert len(dataset.open()) == 2
    assert (len(asked), server.requests) == (1, 0)


def test_a_file_where_the_folder_should_be_is_one_line(server, tmp_path):
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache" / hashlib.sha256(CONTENT).hexdigest()[:16]).write_text("mine")
    assert "is no folder; remove it" in complaint(manifest(server).dataset())


def test_a_server_that_sends_without_end_is_left(server, tmp_path, monkeypatch):
    monkeypatch.setattr(download, "LARGEST", 2 << 20)
    server.content = b"x" * (8 << 20)
    assert "it is larger than 2 MiB" in complaint(manifest(server).dataset())
    assert left(tmp_path) == []


def test_a_copy_that_is_interrupted_leaves_no_half_of_a_file(server, tmp_path, monkeypatch):
    def refuse(*_):
        raise OSError(95, "Operation not supported")

    def full(source, stream):
        stream.write(source.read(5))
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(download.os, "link", refuse)
    with monkeypatch.context() as patch:
        patch.setattr(download, "copyfileobj", full)
        assert "No space left" in complaint(manifest(server).dataset())
    assert left(tmp_path) == []
    assert len(manifest(server).dataset().open()) == 2


def test_without_hard_links_it_is_copied_and_replaces_nothing(server, tmp_path, monkeypatch):
    def refuse(*_):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(download.os, "link", refuse)
    dataset = manifest(server).dataset()
    assert len(dataset.open()) == 2
    [copy] = left(tmp_path)
    with pytest.raises(FileExistsError):
        download._put(copy, copy)


def test_a_link_in_the_cache_leads_nowhere_else(server, tmp_path):
    elsewhere, sha256 = tmp_path / "elsewhere", hashlib.sha256(CONTENT).hexdigest()
    elsewhere.mkdir()
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache" / sha256[:16]).symlink_to(elsewhere)
    with pytest.raises(DataError, match="leads out of its folder"):
        manifest(server).load()
    assert list(elsewhere.iterdir()) == []


def test_a_redirection_to_another_scheme_is_not_followed(server, tmp_path):
    server.moved = f"http://127.0.0.1:{server.server_port}/other.csv"
    assert "without https" in complaint(manifest(server).dataset())
    assert server.requests == 1
    assert left(tmp_path) == []


def test_a_stranger_with_a_certificate_of_his_own_is_not_trusted(server, monkeypatch):
    monkeypatch.delenv("REQUESTS_CA_BUNDLE")
    assert "certificate is not trusted" in complaint(manifest(server).dataset())


def test_a_file_that_is_here_is_not_fetched(server, tmp_path, monkeypatch):
    place = tmp_path / "data" / "my-damper"
    place.mkdir(parents=True)
    (place / "raw.csv").write_bytes(CONTENT + b"4;5;6\n")
    (place / "dataset.toml").write_text(
        MANIFEST.format(url="https://127.0.0.1:9/raw.csv", sha256="0" * 64)
    )
    monkeypatch.setenv(folders.VARIABLE, str(tmp_path / "data"))
    [dataset] = [found for found in folders.datasets() if found.name == "my-damper"]
    assert len(dataset.open()) == 3
    assert server.requests == 0


def test_another_format_than_that_of_the_columns_is_read_by_its_reader(server):
    server.content = b"omega [rad/s],storage [Pa],loss [Pa]\n1,2,3\n4,5,6\n7,8,9\n"
    found = manifest(server, "export.csv", server.content).dataset().open()
    assert (len(found), found.name, found.provenance["licence"]) == (3, "my-damper", "CC0")


def complaint(dataset):
    with pytest.raises(DataError) as caught:
        dataset.open()
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_another_content_is_refused_and_not_kept(server, tmp_path):
    dataset = manifest(server).dataset()
    server.content = CONTENT.replace(b"4", b"5")
    assert "not what was published" in complaint(dataset)
    assert left(tmp_path) == []


def test_an_interrupted_download_leaves_nothing(server, tmp_path):
    dataset = manifest(server).dataset()
    server.sent = 5
    assert "cannot be downloaded" in complaint(dataset) or "checksum" in complaint(dataset)
    assert left(tmp_path) == []
    server.sent = None
    assert len(dataset.open()) == 2, "and the next attempt succeeds"


def test_a_file_that_is_gone_and_a_server_that_is_not_there(server, tmp_path):
    assert "the server answers 404" in complaint(manifest(server, "gone.csv").dataset())
    server.shutdown()
    server.server_close()
    said = complaint(manifest(server).dataset())
    assert "no connection" in said
    assert "SPRINGPOT_DATA" in said


def test_without_pooch_it_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pooch", None)
    monkeypatch.setattr(download, "find_spec", lambda name: None)
    said = read_manifest(
        MANIFEST.format(url="https://example.org/a.csv", sha256="0" * 64), tmp_path, "m"
    ).dataset()
    assert "pip install 'springpot[download]'" in said.unavailable
    assert "pip install 'springpot[download]'" in complaint(said)
    with pytest.raises(DataError, match="pip install"):
        download.fetched("a", "https://example.org/a.csv", "0" * 64)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('sha256 = "{sha256}"', "", "url and sha256"),
        ("{url}", "file:///etc/passwd", "no address with https"),
        ("https:", "http:", "no address with https"),
        ("{url}", "https:///a.csv", "no address with https"),
        ("a.csv", "", "names no file"),
        ("a.csv", "%2f..%2f..%2fmine.csv", "names no file"),
        ("a.csv", "%2e%2e%2f%2e%2e%2fmine.csv", "names no file"),
        ("a.csv", "..", "names no file"),
        ("a.csv", ".bashrc", "names no file"),
        ("a.csv", "a%00.csv", "names no file"),
        ("a.csv", "a%5cb.csv", "names no file"),
        ("{sha256}", "abc", "64 hexadecimal"),
        ('licence = "CC0"', "", "licence that allows it"),
    ],
)
def test_a_faulty_entry(tmp_path, old, new, message):
    text = MANIFEST.format(url="https://example.org/a.csv", sha256="0" * 64)
    made = MANIFEST.replace(old, new).format(url="https://example.org/a.csv", sha256="0" * 64)
    text = text.replace(old, new) if made == text else made
    with pytest.raises(DataError, match=message):
        read_manifest(text, tmp_path, "manifest")


def test_what_is_not_here_is_listed_with_its_origin(monkeypatch):
    monkeypatch.delenv(folders.VARIABLE, raising=False)
    found = {dataset.name: dataset for dataset in folders.datasets()}
    assert "github.com/TFHRC-ABML" in found["fhwa-ptf-binder-dsr"].unavailable
    assert "SPRINGPOT_DATA" in complaint(found["fhwa-ptf-binder-dsr"])


SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"


@pytest.mark.skipif(not SHARED.is_dir(), reason="the shared data are not here")
def test_every_described_set_whose_folder_is_here_opens(monkeypatch):
    """Folders that nobody has described may lie beside them: they are a user's own."""
    monkeypatch.setenv(folders.VARIABLE, str(SHARED))
    sets = list(springpot_datasets())
    names = [name for dataset in sets for name in (dataset.name, *dataset.aliases)]
    assert len(names) == len(set(names))
    described = [
        dataset for dataset in sets if {dataset.name, *dataset.aliases} & set(os.listdir(SHARED))
    ]
    assert described, "none of the folders there is known"
    for dataset in described:
        for fact in (
            "summary",
            "citation",
            "licence",
            "origin",
            "test",
            "columns",
            "physics",
            "size",
        ):
            assert getattr(dataset, fact), (dataset.name, fact)
        assert dataset.where == "here"
        assert len(dataset.open()) == dataset.size, dataset.name


def test_a_folder_that_nobody_describes_is_left_alone(tmp_path, monkeypatch):
    (tmp_path / "my-notes").mkdir()
    (tmp_path / "my-notes" / "rows.csv").write_text("1;2;3\n")
    before = {dataset.name for dataset in folders.datasets()}
    monkeypatch.setenv(folders.VARIABLE, str(tmp_path))
    assert {dataset.name for dataset in folders.datasets()} == before


def folder_of(tmp_path, monkeypatch, text, files):
    """A described folder of two files, in SPRINGPOT_DATA."""
    place = tmp_path / "data" / "mine"
    place.mkdir(parents=True)
    (place / "dataset.toml").write_text(text)
    for name, content in files.items():
        (place / name).write_text(content)
    monkeypatch.setenv(folders.VARIABLE, str(tmp_path / "data"))
    return next(found for found in folders.datasets() if found.name == "mine")


def test_a_set_of_several_files_that_differ_in_temperature(tmp_path, monkeypatch):
    columns = '[columns]\nomega = { from = "w", unit = "rad/s" }\n'
    columns += 'storage = { from = "a", unit = "kPa" }\n'
    columns += 'loss = { from = "b", unit = "kPa" }\n'
    files = (
        '[files]\n"cold.csv" = { "temperature [K]" = 273.15 }\n'
        '"warm.csv" = { "temperature [K]" = 293.15 }\n'
    )
    content = {"cold.csv": "w,a,b\n1,2,3\n2,3,4\n", "warm.csv": "w,a,b\n1,1,2\n"}
    dataset = folder_of(tmp_path, monkeypatch, 'summary = "two"\n' + columns + files, content)
    found = dataset.open()
    np.testing.assert_allclose(found.conditions["temperature"], [0.0, 0.0, 20.0], atol=1e-9)
    np.testing.assert_array_equal(found.stiffness, [2 + 3j, 3 + 4j, 1 + 2j])
    assert "temperature [K]" in dataset.columns
    (tmp_path / "data" / "mine" / "warm.csv").unlink()
    assert (
        "warm.csv is missing" in next(d for d in folders.datasets() if d.name == "mine").unavailable
    )


def test_a_set_that_the_reader_of_its_format_opens(tmp_path, monkeypatch):
    text = 'summary = "an amplitude sweep"\nfile = "sweep.csv"\nopen = "?frequency=1[Hz]"\n'
    text += '[conditions]\n"temperature [K]" = 300\n'
    table = "strain [%],storage [Pa],loss [Pa]\n1,200,30\n2,190,31\n"
    found = folder_of(tmp_path, monkeypatch, text, {"sweep.csv": table}).open()
    np.testing.assert_allclose(found.omega, 2 * np.pi)
    np.testing.assert_array_equal(found.conditions["amplitude"], [1.0, 2.0])
    np.testing.assert_allclose(found.conditions["temperature"], 26.85)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('file = "a.csv"\n[files]\n"b.csv" = {}\n', "one of the two"),
        ('summary = "x"\n', "one of the two"),
        ('[files]\n"b.csv" = { temperature = "warm" }\n', "numbers only"),
        ('file = "a.csv"\ncolumns = 3\n', "is a table"),
    ],
)
def test_a_manifest_that_says_its_files_wrongly(tmp_path, text, message):
    with pytest.raises(DataError, match=message):
        read_manifest(text, tmp_path, "manifest")


@pytest.mark.skipif(not SHARED.is_dir(), reason="the shared data are not here")
def test_the_export_that_is_downloaded_is_the_one_that_the_table_is_made_of(monkeypatch):
    """The checksum of the shipped manifest is that of the file among the shared data."""
    monkeypatch.delenv(folders.VARIABLE, raising=False)
    text = (Path(folders.__file__).parent / "manifests" / "3m-468mp-acrylic-tts.toml").read_text()
    export = SHARED / "instrument-files" / "trios_lims.txt"
    assert (
        read_manifest(text, folders.NOWHERE, "m").download["sha256"]
        == hashlib.sha256(export.read_bytes()).hexdigest()
    )
