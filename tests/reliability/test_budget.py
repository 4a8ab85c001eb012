"""The one rule for readers.

In springpot's own process whatever a reader does ends in time and in its memory.

In a user's own Python nothing is limited or left behind: see test_reading_in_python.
"""

import re
import signal
import sys
import threading
import time

import pytest

from springpot import files, limits
from springpot.errors import DataError
from springpot.limits import own_process, uncounted
from springpot.measurement import Reader, budget_of, open_measurement, within_budget

LINUX = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="only Linux limits the memory of a process"
)


@pytest.fixture(autouse=True)
def own():
    """As in the command line, and in a worker of the page."""
    with own_process():
        yield


@pytest.fixture
def path(tmp_path):
    place = tmp_path / "data.txt"
    place.write_text("anything")
    return place


@pytest.fixture
def short(monkeypatch):
    monkeypatch.setattr(files, "FILES", files.FILES._replace(seconds=0.2))


def for_ever():
    while True:
        pass


def stubborn():
    """Goes on after anything that an ordinary reader catches."""
    while True:
        try:
            for_ever()
        except Exception:
            continue


class Lost:
    """What is raised while it is destroyed is lost."""

    def __del__(self):
        stop = time.thread_time() + 0.3
        while time.thread_time() < stop:
            pass


class Broken:
    """Its own fault, and no word of the budget."""

    def __del__(self):
        raise ValueError("broken")


def loses_the_first_word():
    Lost()
    for_ever()


def test_the_budget_is_that_of_the_documentation(tmp_path):
    path = tmp_path / "a"
    with path.open("wb") as stream:
        stream.truncate(30_000_000)
    found = budget_of(path)
    assert found.seconds == pytest.approx(5.0 + 3.0)
    assert found.memory == 10 * 30_000_000 + 200 * 2**20


@pytest.mark.soak_cases("stubborn", "loses_the_first_word")
@pytest.mark.parametrize("action", [for_ever, stubborn, loses_the_first_word])
@pytest.mark.usefixtures("short")
def test_a_reader_that_never_ends_is_ended(path, action):
    with pytest.raises(DataError, match=r"more than 0\.2 s of processor time") as caught:
        within_budget(path, action)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


@pytest.mark.usefixtures("short")
def test_of_what_a_finaliser_loses_only_other_faults_are_told(path, monkeypatch):
    told = []
    monkeypatch.setattr(sys, "unraisablehook", lambda lost: told.append(lost.exc_type))

    def action():
        Broken()
        loses_the_first_word()

    with pytest.raises(DataError, match="processor time"):
        within_budget(path, action)
    assert told == [ValueError]


def test_another_thread_hears_no_signals_and_simply_reads(path):
    read = []
    thread = threading.Thread(target=lambda: read.append(within_budget(path, path.read_text)))
    thread.start()
    thread.join()
    assert read == ["anything"]


def test_a_plugin_that_never_ends_is_ended_too(path, short):
    reader = Reader("slow", "never ends", lambda head: 1.0, lambda path, choice: for_ever())
    with pytest.raises(DataError, match="processor time"):
        open_measurement(path, (), [reader])
    thinker = Reader("thinker", "never knows", lambda head: for_ever(), lambda path, choice: None)
    with pytest.raises(DataError, match="processor time"):
        open_measurement(path, (), [thinker])


@pytest.mark.soak
def test_what_ends_about_when_its_time_does_leaves_nothing_behind(path, monkeypatch):
    monkeypatch.setattr(files, "FILES", files.FILES._replace(seconds=0.02))
    monkeypatch.setattr(limits, "_TICK", 0.001)
    handler = signal.getsignal(signal.SIGPROF)
    ended = 0
    for i in range(30):
        last = time.thread_time() + 0.02 + (i - 10) * 1e-3
        try:
            within_budget(
                path,
                lambda last=last: [None for _ in iter(lambda: time.thread_time() < last, False)],
            )
        except DataError:
            ended += 1
        for _ in range(1000):  # where a word that came too late would be heard
            pass
    assert 0 < ended < 30
    assert signal.getitimer(signal.ITIMER_PROF) == (0.0, 0.0)
    assert signal.getsignal(signal.SIGPROF) is handler


def gigabyte():
    """In pieces: one alone may be had from what the process was given and has not returned."""
    return [bytearray(64 << 20) for _ in range(16)]


@LINUX
def test_a_reader_that_takes_all_memory_is_ended_and_gives_it_back(path):
    import resource

    before = resource.getrlimit(resource.RLIMIT_AS)
    with pytest.raises(DataError, match="more than 200 MiB of memory"):
        within_budget(path, gigabyte)
    assert resource.getrlimit(resource.RLIMIT_AS) == before
    assert len(within_budget(path, lambda: bytearray(60 << 20))) == 60 << 20
    assert len(bytearray(220 << 20)) == 220 << 20


@LINUX
def test_a_budget_within_a_budget(path):
    with pytest.raises(DataError, match="memory"):
        within_budget(path, lambda: (within_budget(path, lambda: 1), gigabyte()))


def test_errors_and_answers_pass(path):
    assert within_budget(path, lambda: 42) == 42
    with pytest.raises(DataError, match=re.escape("of the reader")):
        within_budget(path, lambda: (_ for _ in ()).throw(DataError("of the reader")))
    with pytest.raises(KeyboardInterrupt):
        within_budget(path, lambda: (_ for _ in ()).throw(KeyboardInterrupt()))


@pytest.mark.soak
@pytest.mark.usefixtures("short")
def test_what_springpot_makes_of_the_data_is_not_counted_against_the_reader(path):
    def spend(seconds):
        stop = time.thread_time() + seconds
        while time.thread_time() < stop:
            pass

    def reads_and_lets_work():
        with uncounted():
            spend(0.3)
        return "done"

    assert within_budget(path, reads_and_lets_work) == "done"
    with pytest.raises(DataError, match="processor time"):
        within_budget(path, lambda: (reads_and_lets_work(), spend(0.3)))
    with uncounted():
        spend(0.0)


@pytest.mark.soak
def test_no_word_is_heard_after_the_end_however_slowly_a_reader_unwinds(path, monkeypatch):
    """A word said while another is being heard escaped, once, into what came after the reading."""
    # Kernels count processor time in steps of up to 10 ms: the end falls among works so long.
    monkeypatch.setattr(files, "FILES", files.FILES._replace(seconds=0.02))
    monkeypatch.setattr(limits, "_TICK", 0.0005)
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-4)

    def unwinds(count, last):
        try:
            while time.thread_time() < last:
                pass
        finally:
            sorted(range(count))

    ended = 0
    try:
        for i in range(150):
            last = time.thread_time() + 0.02 + (i % 7 - 3) * 4e-3
            try:
                within_budget(path, lambda i=i, last=last: unwinds(37 * i % 20_000, last))
            except DataError:
                ended += 1
            for _ in range(300):
                pass
    finally:
        sys.setswitchinterval(interval)
    assert 0 < ended < 150
