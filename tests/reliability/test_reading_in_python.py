"""In a user's own Python a file is simply read.

No limit, timer, signal, thread or lock of the process is touched.
"""

import signal
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

import springpot
from springpot.measurement import within_budget

TABLE = "frequency [Hz],storage [kN/m],loss [kN/m]\n" + "".join(
    f"{i},{2 * i},{3 * i}\n" for i in range(1, 11)
)
LINUX = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="only Linux limits the memory of a process"
)


@pytest.fixture
def table(tmp_path):
    path = tmp_path / "damper.csv"
    path.write_text(TABLE, encoding="utf-8")
    return path


WATCHED = """
import cProfile, sys, springpot
springpot.read(sys.argv[1])
work = lambda: sorted(range(9))
profiler = cProfile.Profile()
profiler.enable(); work(); profiler.disable()
sys.setprofile(lambda frame, event, argument: None); work(); sys.setprofile(None)
sys.settrace(lambda frame, event, argument: None); work(); sys.settrace(None)
print("goes on")
"""
"""As profilers, coverage tools and debuggers do."""


@pytest.mark.soak
def test_a_tool_that_watches_works_after_a_read(table):
    # Before, it turned for ever: longer than any import on a busy machine.
    done = subprocess.run(
        [sys.executable, "-c", WATCHED, table],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, "goes on\n"), done.stderr


def state():
    """What is of the whole process."""
    import resource

    return (
        resource.getrlimit(resource.RLIMIT_AS),
        resource.getrlimit(resource.RLIMIT_CPU),
        [
            signal.getitimer(timer)
            for timer in (signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF)
        ],
        [signal.getsignal(number) for number in (signal.SIGALRM, signal.SIGVTALRM, signal.SIGPROF)],
        threading.active_count(),
        sys.unraisablehook,
    )


@LINUX
def test_nothing_of_the_process_is_other_while_a_file_is_read(table):
    before = state()
    assert within_budget(table, state) == before
    assert state() == before


def test_two_files_are_read_at_once(table):
    both = threading.Barrier(2, timeout=20.0)

    def read():
        return within_budget(table, lambda: (both.wait(), springpot.read(table))[1])

    with ThreadPoolExecutor(2) as pool:
        found = [job.result() for job in [pool.submit(read) for _ in range(2)]]
    assert [len(data) for data in found] == [10, 10]
