"""A limit of memory is lifted before anything else is done."""

import resource
import signal

import pytest

from springpot import limits


def test_memory_is_given_back_before_the_clock_is_put_away(monkeypatch):
    """Where memory is at its end CPython 3.11 does not survive the call of a function."""
    done = []
    set_limit, set_handler = resource.setrlimit, signal.signal
    monkeypatch.setattr(
        resource, "setrlimit", lambda *ends: (done.append("memory"), set_limit(*ends))
    )
    monkeypatch.setattr(
        signal, "signal", lambda *ends: (done.append("clock"), set_handler(*ends))[1]
    )

    def eats():
        done.append("work")
        raise MemoryError

    before = resource.getrlimit(resource.RLIMIT_AS)
    with limits.own_process(), pytest.raises(MemoryError):
        limits.limited(eats, 5.0, 1 << 30)
    assert done == ["clock", "memory", "work", "memory", "clock"]
    assert resource.getrlimit(resource.RLIMIT_AS) == before
