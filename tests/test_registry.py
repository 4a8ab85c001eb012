"""The plugin host: what a plugin does wrong is said in one line, and all else works on."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.metadata import PathDistribution
from itertools import count
from pathlib import Path

import pytest

from springpot import errors
from springpot.cli.group import exit_code, run
from springpot.errors import ModelError, PluginError
from springpot.processes import surroundings
from springpot.registry import Registry, plugins

GOOD = """
from springpot.hooks import hookimpl
from springpot.rheology import Effect, Model, mass, parallel, spring


def model(name, *aliases):
    return Model(name, spring(), "a spring", "nobody (2024)", aliases)


def effect(name):
    return Effect(name, parallel, mass(), "a mass")

"""
MODELS = GOOD + "@hookimpl\ndef springpot_models():\n    return [{}]\n"
HEAVY = ("scipy.optimize", "cma", "nlopt", "matplotlib", "pandas", "pytest", "rich", "dask")
Install = Callable[..., Registry]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A registry of distributions, each the source of its only module, named by its keyword."""
    numbers = count()

    def loaded(**sources: str) -> Registry:
        points = []
        for name, source in sources.items():
            module = f"{name}_{next(numbers)}_{tmp_path.name.replace('-', '_')}"
            (tmp_path / f"{module}.py").write_text(source)
            info = tmp_path / f"{module}.dist-info"
            info.mkdir()
            distribution = name if name == "springpot" else f"dist-{name}"
            (info / "METADATA").write_text(
                f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1\n"
            )
            (info / "entry_points.txt").write_text(f"[springpot]\nplugin = {module}\n")
            points += PathDistribution(info).entry_points
        return Registry(points)

    monkeypatch.syspath_prepend(tmp_path)
    return loaded


BROKEN = {
    "a missing library": (
        "import no_such_library\n",
        "ModuleNotFoundError: No module named 'no_such_library'",
    ),
    "an exit": ("import sys\nsys.exit('no licence')\n", "SystemExit: no licence"),
    "a fault beneath Exception": (
        "class Panic(BaseException): ...\nraise Panic('rust')\n",
        "Panic: rust",
    ),
    "a syntax error": ("def f(:\n", "SyntaxError: invalid syntax"),
    "a long complaint": (
        "raise ImportError('one\\ntwo\\n' + 1000 * 'x')\n",
        "ImportError: one two x",
    ),
    "a hook that raises": (
        GOOD + "@hookimpl\ndef springpot_models():\n    1 / 0\n",
        "ZeroDivisionError",
    ),
    "a hook that exits": (
        GOOD + "@hookimpl\ndef springpot_models():\n    raise SystemExit(3)\n",
        "SystemExit: 3",
    ),
    "nothing returned": (
        GOOD + "@hookimpl\ndef springpot_models(): ...\n",
        "must return a list of models, not None",
    ),
    "one thing, no list": (
        GOOD + "@hookimpl\ndef springpot_models():\n    return model('m')\n",
        "must return a list of models, not <Model",
    ),
    "a word": (
        GOOD + "@hookimpl\ndef springpot_models():\n    return 'kelvin'\n",
        "a list of models, not 'kelvin'",
    ),
    "another kind": (MODELS.format("effect('e')"), "springpot_models offers Effect(name='e'"),
    "an instance": (
        GOOD + "@hookimpl\ndef springpot_optimisers():\n    return [object()]\n",
        "which is no optimiser (offer the class itself",
    ),
    "an unfinished class": (
        GOOD + "from springpot.identification import Optimiser\nclass Mine(Optimiser):\n"
        "    name = 'mine'\n@hookimpl\ndef springpot_optimisers():\n    return [Mine]\n",
        "which is no optimiser (offer the class itself, with minimise written)",
    ),
    "no name": (MODELS.format("model('')"), "offers a model without a name"),
    "a name that is none": (MODELS.format("model(3)"), "offers a model without a name"),
    "aliases in no tuple": (
        MODELS.format("Model('m', spring(), aliases='other')"),
        "aliases must be a tuple such as ('m-2',), not 'other'",
    ),
    "two parameters of one name": (
        MODELS.format("Model('m', parallel(spring(), spring()))"),
        "model 'm' has two parameters called k: rename one of them",
    ),
    "an argument": (
        GOOD + "@hookimpl\ndef springpot_models(data):\n    return []\n",
        "springpot_models(data)",
    ),
    "a misspelt hook": (
        GOOD + "@hookimpl\ndef springpot_modles():\n    return []\n",
        "there is no hook springpot_modles: did you mean springpot_models?",
    ),
    "an unheard-of hook": (
        GOOD + "@hookimpl\ndef springpot_xyzzy():\n    return []\n",
        "springpot_xyzzy: known are",
    ),
    "a forgotten mark": (
        GOOD + "def springpot_models():\n    return [model('m')]\n",
        "springpot_models is not marked with @hookimpl and does nothing",
    ),
}


@pytest.mark.parametrize("case", BROKEN)
def test_what_is_broken_is_listed_with_its_reason_and_distribution_and_the_rest_works(
    install: Install, case: str
):
    source, reason = BROKEN[case]
    found = install(
        before=MODELS.format("model('before')"),
        broken=source,
        later=MODELS.format("model('later')"),
    )
    [fault] = found.faults
    assert fault.distribution == "dist-broken"
    assert reason in fault.reason
    assert "\n" not in str(fault)
    assert len(fault.reason) <= 300
    assert found.names("model") == ["before", "later"]
    assert found.model("before").names == ("k",)


def test_one_bad_thing_leaves_the_other_things_of_its_plugin(install: Install):
    found = install(mixed=MODELS.format("model('first'), None, model('second')"))
    assert found.names("model") == ["first", "second"]
    assert "offers None, which is no model" in found.faults[0].reason


def test_a_fault_in_one_hook_leaves_the_plugin_s_other_hooks(install: Install):
    source = (
        MODELS.format("model('good')")
        + "@hookimpl\ndef springpot_effects():\n    raise OSError('disk')\n"
    )
    found = install(half=source)
    assert found.names("model") == ["good"]
    assert [fault.reason for fault in found.faults] == ["OSError: disk"]


def test_what_a_generator_gave_before_it_failed_is_kept(install: Install):
    source = (
        GOOD + "@hookimpl\ndef springpot_models():\n    yield model('early')\n"
        "    raise ValueError('late')\n"
    )
    found = install(generator=source)
    assert found.names("model") == ["early"]
    assert [fault.reason for fault in found.faults] == ["ValueError: late"]


def test_an_interruption_is_not_swallowed(install: Install):
    with pytest.raises(KeyboardInterrupt):
        install(stopped="raise KeyboardInterrupt\n")


def test_one_name_of_two_plugins_is_an_error_that_names_both(install: Install):
    found = install(
        one=MODELS.format("model('twin'), model('mine')"), two=MODELS.format("model('twin')")
    )
    with pytest.raises(PluginError) as caught:
        found.model("twin")
    for word in ("model 'twin'", "plugin 'plugin' of dist-one", "of dist-two", "uninstall one"):
        assert word in str(caught.value)
    assert [fault.reason for fault in found.faults] == [str(caught.value)]
    assert found.names("model") == ["mine"] == [model.name for model in found.items("model")]


def test_two_distributions_may_choose_the_same_name_for_their_entry_point(install: Install):
    found = install(one=MODELS.format("model('a')"), two=MODELS.format("model('b')"))
    assert found.faults == []
    assert found.shelves["model"].owners == {"a": "plugin", "b": "plugin (dist-two)"}


def test_one_plugin_that_offers_a_name_twice_keeps_the_first(install: Install):
    found = install(one=MODELS.format("model('twin', 'first'), model('twin', 'second')"))
    assert found.model("twin").aliases == ("first",)
    assert [fault.reason for fault in found.faults] == [
        "model 'twin' is offered twice; the first is used"
    ]


@pytest.mark.parametrize("order", [1, -1])
def test_an_alias_gives_way_to_another_s_name_and_this_is_reported(install: Install, order: int):
    sources = {
        "claims": MODELS.format("model('a', 'b', 'c')"),
        "named": MODELS.format("model('b')"),
    }
    found = install(**dict(list(sources.items())[::order]))
    assert found.model("b").base == "b"
    assert found.model("c").base == "a"
    [fault] = found.faults
    assert fault.distribution == "dist-claims"
    assert "alias 'b' of model 'a' is the name of another, of plugin" in fault.reason
    assert "dist-named" in fault.reason


def test_an_alias_of_two_things_is_an_error_that_names_both(install: Install):
    found = install(one=MODELS.format("model('a', 'x')"), two=MODELS.format("model('b', 'x')"))
    with pytest.raises(
        PluginError,
        match=r"alias 'x' of model 'b' .*dist-two is also an alias of 'a' of .*dist-one",
    ):
        found.model("x")
    assert [fault.reason for fault in found.faults] == [found.shelves["model"].clashes["x"]]
    assert found.names("model") == ["a", "b"]
    assert "x" not in found.shelves["model"].known()


def test_an_alias_that_is_the_own_name_is_reported(install: Install):
    found = install(one=MODELS.format("model('a', 'a')"))
    assert found.model("a").base == "a"
    assert "alias 'a' of model 'a' is its own name" in found.faults[0].reason


def test_a_name_that_a_family_has_for_its_member_is_in_dispute(install: Install):
    family = "from springpot.rheology.model import Family\n"
    found = install(
        one=family
        + MODELS.format("Family('row-N', lambda n: model(f'row-{n}'), aliases=('chain-N',))"),
        two=MODELS.format("model('row-7'), model('other', 'chain-2')"),
    )
    assert found.model("row-3").base == found.model("chain-3").base == "row-3"
    assert found.model("other").base == "other"
    for name in ("row-7", "chain-2"):
        with pytest.raises(
            PluginError,
            match=rf"'{name}' of .*dist-two is also a member of the family row-N of .*one",
        ):
            found.model(name)
    with pytest.raises(ModelError, match="needs a number for N, such as row-3"):
        found.model("row-N")


def test_the_order_does_not_depend_on_the_order_of_installation(install: Install):
    sources = {name: MODELS.format(f"model('{name}')") for name in ("beta", "springpot", "alpha")}
    names = [install(**dict(list(sources.items())[::step])).names("model") for step in (1, -1)]
    assert names[0] == names[1] == ["springpot", "alpha", "beta"]


def test_springpot_s_own_plugins_come_first_and_have_no_faults():
    assert plugins().faults == []
    assert next(iter(plugins().shelves["reader"].owners.values())).startswith("builtin")


@pytest.mark.soak
def test_plugins_are_asked_for_the_kinds_that_are_wanted_alone():
    code = (
        "import sys; from springpot.registry import plugins; plugins().names('reader')\n"
        "print(*sys.modules)"
    )
    told = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert "springpot_plugins.readers.excel" in told
    assert not {"springpot_plugins.optimisers.swarm", "springpot_plugins.models.paper"} & {*told}


def test_heavy_libraries_are_not_imported_by_loading_the_plugins():
    code = (
        "import sys; from springpot.registry import plugins; found = plugins()\n"
        "assert len(found.names('model')) > 5 and len(found.names('optimiser')) > 5, found.faults\n"
        "print(*sys.modules)"
    )
    told = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert "springpot_plugins.models" in told
    assert [name for name in HEAVY if name in told] == []


def test_the_list_of_heavy_libraries_names_some_that_are_used():
    for name in ("cma", "scipy.optimize"):
        assert import_module(name).__name__ == name
        assert name in HEAVY


RUDE = """
import atexit, os, sys
from fractions import Fraction
import numpy as np
os.chdir("/")
sys.path.insert(0, "/rude")
os.environ["RUDE"] = "1"
del os.environ["POLITE"]
sys.setrecursionlimit(7777)
np.seterr(all="raise")
sys.excepthook = print
atexit.register(Fraction)


@atexit.register
def farewell():
    pass
"""


def test_what_a_plugin_does_to_the_program_when_it_is_loaded_is_undone_and_named(
    install: Install, monkeypatch
):
    """Functions of other libraries stay among those that run at the exit: they are theirs."""
    import atexit

    left = []
    monkeypatch.setattr(atexit, "unregister", left.append)
    monkeypatch.setenv("POLITE", "as it was")
    before = surroundings()
    found = install(rude=RUDE + MODELS.format("model('polite')"))
    assert surroundings() == before
    [fault] = found.faults
    for told in (
        "the recursion limit",
        "the working folder",
        "where modules are looked for",
        "the environment's variables",
        "way with errors",
        "what runs at the exit",
    ):
        assert told in fault.reason
    assert [function.__name__ for function in left] == ["farewell"]
    assert found.names("model") == ["polite"]


BUSY = """
import threading
let_go = threading.Event()
busy = threading.Thread(target=let_go.wait, name="busy", daemon=True)
busy.let_go = let_go.set
busy.start()
"""


@pytest.fixture
def let_go_of_busy() -> Iterator[None]:
    """A thread that stays would be in the way of all later tests that copy their process."""
    yield
    for thread in threading.enumerate():
        if thread.name == "busy":
            thread.let_go()
            thread.join()


@pytest.mark.usefixtures("let_go_of_busy")
def test_a_thread_that_a_plugin_leaves_running_is_named(install: Install):
    found = install(busy=BUSY + MODELS.format("model('polite')"))
    [fault] = found.faults
    assert fault.distribution == "dist-busy"
    assert "leaves a thread running (busy)" in fault.reason
    assert found.names("model") == ["polite"]


FAULTY = """
import numpy as np
from springpot.hooks import hookimpl
from springpot.identification import Objective
from springpot.measurement import DataSet, Measurement, Reader
from springpot.rheology import Effect, Formula, Model, Parameter, parallel

BAD = {bad!r}


def no_number():
    if BAD == "raise":
        1 / 0
    return np.nan


def law(at, m):
    value = m * at.omega**2 * no_number() + 0j
    return value, (value / m,), 2 * value


def read(*_):
    return Measurement([1.0, 2.0], [no_number(), 1j])


LAW = Formula((Parameter("m", "m"),), law, kind="bad " + BAD)


@hookimpl
def springpot_effects():
    return [Effect("bad-effect", parallel, LAW, "bad")]


@hookimpl
def springpot_models():
    return [Model("bad-model", LAW, "bad", "nobody")]


@hookimpl
def springpot_objectives():
    return [Objective("bad-objective", "bad", lambda data: np.full(len(data), no_number() + 0j))]


@hookimpl
def springpot_datasets():
    return [DataSet("bad-data", "bad", read)]


@hookimpl
def springpot_readers():
    return [Reader("bad-reader", "bad", lambda head: float(head.startswith(b"BAD")), read)]
"""
DATA = "artificial-springpot"
ASKED = {
    "effect": (DATA, "--model", "kelvin + bad-effect"),
    "model": (DATA, "--model", "bad-model"),
    "objective": (DATA, "--model", "springpot", "--objective", "bad-objective"),
    "data set": ("bad-data", "--model", "springpot"),
    "reader": ("bad.txt", "--model", "springpot"),
}


@pytest.mark.parametrize("bad", ["nan", "raise"])
def test_a_plugin_that_gives_no_number_or_raises_is_named(
    install: Install, tmp_path, monkeypatch, capsys, bad: str
):
    """Exit code 2 in one line, whatever kind of thing it is."""
    before = plugins()
    offered = install(faulty=FAULTY.format(bad=bad))
    for word, shelf in before.shelves.items():
        for name, item in offered.shelves[word].items.items():
            monkeypatch.setitem(shelf.items, name, item)
            monkeypatch.setitem(shelf._from, name, offered.shelves[word].owner(name))
    monkeypatch.setattr(errors, "_by_module", offered.owner_of_module)
    monkeypatch.chdir(tmp_path)
    Path("bad.txt").write_text("BAD\n")
    for asked in ASKED.values():
        assert exit_code(lambda asked=asked: run(["identify", *asked])) == 2
        told = capsys.readouterr().err
        assert told.count("\n") == 1
        assert "plugin 'plugin' of dist-faulty" in told


def test_an_unknown_name_may_be_what_a_broken_plugin_would_have_offered(install: Install):
    registry = install(mine="import no_such_library\n")
    says = "unknown model 'mine': .*; plugin 'plugin' of dist-mine is unavailable: ModuleNotFound"
    with pytest.raises(ModelError, match=says):
        registry.find("model", "mine")
