"""A guest brings its commands by the entry-point group; one that is faulty takes no other down."""

from importlib.metadata import EntryPoint

import pytest

from springpot.cli import group as table


@pytest.fixture
def guests(monkeypatch):
    """Lets a test say which guests are installed."""

    def install(*values):
        points = [EntryPoint(f"guest{i}", value, table.GROUP) for i, value in enumerate(values)]
        monkeypatch.setattr(table, "entry_points", lambda group: points)
        table.commands.cache_clear()
        return table.commands()

    yield install
    monkeypatch.undo()
    table.commands.cache_clear()


def test_without_guests_there_is_the_core(guests):
    assert guests() == table.CORE


def test_a_guest_adds_its_commands(guests):
    found = guests("springpot.structure.commands:COMMANDS")
    assert found["simulate"].module == "springpot.structure.commands.simulate"


def test_a_guest_takes_no_command_of_the_core(guests, monkeypatch):
    monkeypatch.setattr(
        "springpot.structure.commands.COMMANDS", {"identify": ("elsewhere", "other")}
    )
    assert guests("springpot.structure.commands:COMMANDS") == table.CORE


def test_a_guest_that_cannot_be_loaded_is_told_by_name_and_the_others_stay(guests, springpot):
    found = guests("no_such_module:COMMANDS", "springpot.structure.commands:COMMANDS")
    assert "cannot be loaded: ModuleNotFoundError" in found["guest0"].summary
    assert "simulate" in found
    answer = springpot("guest0")
    assert answer.code == 2
    assert answer.err.count("\n") == 1
    assert "guest0" in answer.err
