"""The house keeps its order: who imports whom, and no trace of the machine it was built on."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import pytest

from springpot.registry import plugins

ROOT = Path(__file__).resolve().parents[1]
FRAMEWORK = ROOT / "framework" / "springpot"
PLUGINS = ROOT / "plugins" / "springpot_plugins"

FLOORS = {
    "lazy": -1,
    "writing": 0,
    "limits": -1,
    "numerics": -1,
    "errors": 0,
    "distributions": 0,
    "thresholds": 0,
    "plain_data": 1,
    "processes": 1,
    "files": 1,
    "rheology": 1,
    "measurement": 2,
    "identification": 3,
    "hooks": 5,
    "registry": 6,
    "constraints": 7,
    "misfit": 7,
    "diagnosis": 8,
    "superposition": 8,
    "timetests": 10,
    "comparison": 9,
    "invention": 9,
    "testing": 11,
    "api": 12,
    "loading": 10,
    "report": 13,
    "cli": 14,
    "benchmark": 15,
    "derived": 15,
    "solvers": 15,
    "structure": 15,
    "testreport": 15,
    "web": 16,
}
"""A room may import from rooms below it and from itself; two rooms on one floor do not meet."""

GUESTS = {"benchmark", "derived", "solvers", "structure", "testreport", "web"}
"""Each brings commands by the entry-point group and could move out by moving one folder."""

FOR_PLUGINS = {
    *("errors", "hooks", "rheology", "measurement", "identification", "timetests", "solvers"),
}


class Facts(NamedTuple):
    """What is asked of a file, read once.

    Its imports, those at once (not in functions or for types), texts other than docstrings with
    their lines, names of classes, lines of code, functions with theirs, and its constants that hold
    a number.
    """

    imports: list[ast.Import | ast.ImportFrom]
    at_once: list[ast.Import | ast.ImportFrom]
    texts: list[tuple[int, str]]
    classes: list[str]
    lines: int
    functions: dict[str, int]
    numbers: list[str]


@cache
def facts(path: Path) -> Facts:
    """Those of a file."""
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text)
    nodes = list(ast.walk(tree))
    alone = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    functions = [n for n in nodes if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
    return Facts(
        [node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom)],
        [node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)],
        [
            (node.lineno, node.value)
            for node in nodes
            if isinstance(node, ast.Constant)
            and isinstance(node.value, str)
            # Examples in docstrings run with what is installed here.
            and id(node) not in alone
        ],
        [node.name for node in nodes if isinstance(node, ast.ClassDef)],
        lines_of_code(text, nodes),
        {node.name: code_lines(node) for node in sorted(functions, key=code_lines)},
        [
            next(part.id for part in ast.walk(node) if isinstance(part, ast.Name))
            for node in tree.body
            if isinstance(node, ast.Assign | ast.AnnAssign) and holds_number(node)
        ],
    )


def holds_number(node: ast.AST) -> bool:
    """Whether a number is written in an expression or a statement; true and false are none."""
    return any(
        isinstance(part, ast.Constant) and type(part.value) in (int, float)
        for part in ast.walk(node)
    )


def imported(path: Path, package: str) -> set[str]:
    """Absolute names of all modules that a file imports, inside functions too."""
    return names_of(facts(path).imports, package)


def names_of(imports: list[ast.Import | ast.ImportFrom], package: str) -> set[str]:
    """Absolute names of imported modules."""
    names: set[str] = set()
    for node in imports:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
            continue
        base = package.split(".")
        base = base[: len(base) - node.level + 1] if node.level else []
        start = ".".join([*base, *([node.module] if node.module else [])])
        names |= {start} | {f"{start}.{alias.name}" for alias in node.names}
    return names


def modules(root: Path) -> Iterator[tuple[Path, str]]:
    """Python files below `root` with the package that their relative imports start from."""
    for path in sorted(root.rglob("*.py")):
        yield path, ".".join(path.parent.relative_to(root.parent).parts)


def rooms(names: set[str]) -> set[str]:
    """The rooms of the framework among imported names."""
    return {
        parts[1]
        for name in names
        if (parts := name.split("."))[0] == "springpot" and len(parts) > 1
    }


FILES = [(path, package) for path, package in modules(FRAMEWORK)]
OWN = [(path, package) for path, package in modules(PLUGINS)]


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


def room_of(path: Path) -> str:
    return path.relative_to(FRAMEWORK).with_suffix("").parts[0]


def test_imports_go_one_way():
    guilty = [
        f"{name_of(path)} must not import {room}"
        for path, package in FILES
        if (floor := FLOORS.get(room_of(path))) is not None
        for room in rooms(imported(path, package)) - {room_of(path)}
        if FLOORS.get(room, 0) >= floor
    ]
    assert guilty == []


def test_the_core_imports_no_guest():
    """The front door alone names what the workbench offers, and imports it when it is asked for."""
    guilty = [
        f"{name_of(path)} must not import {room}"
        for path, package in FILES
        if room_of(path) not in {*GUESTS, "__init__"}
        for room in rooms(imported(path, package)) & GUESTS
    ]
    assert guilty == []


def test_the_core_names_no_module_of_a_guest():
    guest = re.compile(rf"springpot\.(?:{'|'.join(GUESTS)})\b")
    named = [
        path
        for path, _ in FILES
        if path.relative_to(FRAMEWORK).parts[0] not in {*GUESTS, "__init__.py"}
    ]
    assert [
        path.name for path in named if any(guest.search(text) for _, text in facts(path).texts)
    ] == []


def test_the_framework_knows_no_plugin():
    guilty = [
        f"{name_of(path)} must not import {name}"
        for path, package in FILES
        for name in imported(path, package)
        if name.startswith("springpot_plugins")
    ]
    assert guilty == []


def test_the_framework_names_no_effect():
    """Names that could be ordinary words, such as friction, are passed over."""
    names = [name for name in plugins().names("effect") if "-" in name]
    pattern = re.compile(rf"(?<![\w-])(?:{'|'.join(names)})(?![\w-])")
    guilty = []
    for path, _ in FILES:
        for line, text in facts(path).texts:
            guilty += [
                f"{path.relative_to(ROOT)}:{line}: {found}" for found in pattern.findall(text)
            ]
    assert guilty == []


def test_plugins_use_only_public_rooms():
    guilty = [
        f"{name_of(path)} must not import {room}"
        for path, package in OWN
        for room in rooms(imported(path, package)) - FOR_PLUGINS
    ]
    assert guilty == []


def importing(files: list[tuple[Path, str]]) -> dict[str, set[str]]:
    """Names of modules and packages, each with those of them that its file imports."""
    named = {}
    for path, package in files:
        name = package if path.stem == "__init__" else f"{package}.{path.stem}"
        named[name] = imported(path, package) - {name}
    return {name: found & named.keys() for name, found in named.items()}


@pytest.mark.parametrize("files", [FILES, OWN], ids=["framework", "plugins"])
def test_no_files_import_each_other(files: list[tuple[Path, str]]):
    """Neither for types nor inside functions.

    What two files need of one another belongs below both.

    The list of names that a package offers is a file too: a file that asks its own package for a
    name comes back to itself.
    """
    tuple(TopologicalSorter(importing(files)).static_order())  # a CycleError names the files


@pytest.mark.parametrize(
    "second",
    [
        "from .one import a",
        "from __future__ import annotations\nif TYPE_CHECKING:\n    from room.one import a",
        "def f():\n    import room.one",
        "from room import a",
    ],
)
def test_a_circle_is_seen(tmp_path: Path, second: str):
    room = tmp_path / "room"
    room.mkdir()
    (room / "__init__.py").write_text("from .one import a\n", encoding="utf-8")
    (room / "one.py").write_text("from .two import b\n", encoding="utf-8")
    (room / "two.py").write_text(f"{second}\n", encoding="utf-8")
    with pytest.raises(CycleError):
        tuple(TopologicalSorter(importing(list(modules(room)))).static_order())


SCREEN = 50
"""Lines of code of a function that can be seen at once; its docstring is read before, not with it.
"""
LONGEST = 400
"""Lines of code of a file that one finds one's way in: without docstrings, comments and blanks."""


def code_lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of a function without those of its docstring."""
    assert function.end_lineno is not None
    lines = function.end_lineno - function.lineno + 1
    first = function.body[0]
    if ast.get_docstring(function, clean=False) is not None and first.end_lineno is not None:
        lines -= first.end_lineno - first.lineno + 1
    return lines


def lines_of_code(text: str, nodes: list[ast.AST]) -> int:
    """Lines of a file without docstrings, comments and blanks."""
    told: set[int] = set()
    for node in nodes:
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            told |= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    lines = enumerate(text.splitlines(), 1)
    return sum(
        number not in told and bool(line.strip()) and not line.lstrip().startswith("#")
        for number, line in lines
    )


def test_a_file_can_be_read():
    known = {name_of(path): facts(path) for path, _ in [*FILES, *OWN]}
    assert [f"{name}: {it.lines} lines" for name, it in known.items() if it.lines > LONGEST] == []
    guilty = [
        f"{name}: {function} does not fit a screen, name its steps"
        for name, it in known.items()
        for function, lines in it.functions.items()
        if lines > SCREEN
    ]
    assert guilty == []


DEEPEST = 20
"""Files of the longest chain of imports; may only fall (53 before imports named their files)."""
TWICE = 0
"""Names of classes that stand for two things or more; may only fall."""
MODULES, OF_PLUGINS = 271, 65
"""Files of the framework, and of the plugins; may only fall."""
FACTS = {
    "benchmark/exporting.py": "PRECISION",
    "benchmark/plan.py": "SCHEME",
    "benchmark/schema.py": "SCHEMA NO_REFERENCES SIZE",
    "benchmark/statistics.py": "PRIOR",
    "cli/common.py": "POSITIVE",
    "cli/group.py": "BAD_INPUT",
    "comparison/comparing.py": "MOST_AT_ONE_FREQUENCY",
    "diagnosis/notes.py": "MEANINGS",
    "diagnosis/verdict.py": "ALARMED",
    "errors.py": "STDERR",
    "identification/robust.py": "TUNED",
    "identification/searching.py": "BUDGET",
    "identification/space.py": "LARGEST",
    "identification/value.py": "MOST_POINTS",
    "measurement/geometry.py": "AREA_UNITS _TABLES",
    "measurement/timetest.py": "PLANNED_IN IMMENSE",
    "measurement/units.py": "FORCE_UNITS LENGTH_UNITS TORQUE_UNITS ANGLE_UNITS PRESSURE_UNITS"
    " STRAIN_UNITS FREQUENCY_UNITS TIME_UNITS TEMPERATURE_UNITS MODULUS_UNITS _USUAL _PREFIXES",
    "measurement/instrument.py": "MAINS",
    "misfit/residual_tests.py": "TESTS",
    "misfit/where.py": "AMPLITUDE_POWERS FREQUENCY_POWERS",
    "numerics.py": "DECADE NORMAL MEDIAN_WORTH TWO_DEVIATIONS SMALLEST LARGEST HALVINGS",
    "processes.py": "ADOPT",
    "report/figures.py": "COLUMN",
    "report/page.py": "LONGEST",
    "rheology/grammar.py": "OF_VARIABLE OF_PLANE GAS",
    "rheology/hysteresis.py": "STAGE NEWTON_STEPS",
    "rheology/model.py": "STEP",
    "rheology/nodes.py": "VALUE _ABSENT MOVING_SERIES FIXED_SERIES _SERIES",
    "rheology/parameters.py": "STIFFNESS VISCOSITY INERTANCE FORCE AMPLITUDE SECOND"
    " RADIAN_PER_SECOND MARGIN MAXWELL_FORM KELVIN_FORM",
    "rheology/points.py": "KELVIN GAS_CONSTANT FURTHEST",
    "rheology/terms.py": "FOUR_OVER_PI JOINED CALLED",
    "structure/answers.py": "LARGEST",
    "structure/reading.py": "ACCELERATIONS HEADER",
    "testing/others.py": "TRUTH",
    "testreport/code.py": "_KINDS MEANS",
    "testreport/quantities.py": "QUANTITIES",
    "misfit/residual_scatter.py": "EFFICIENT",
}
"""Constants that nobody could choose otherwise: units, dimensions, series, versions, formats,
numbers of a source, signs and positions, ends of what a floating-point number can be or tell.
"""
NUMBERS, WITH_PLUGINS = 485, 629
"""Constants of modules that hold a number and are no facts, those of the framework and all; may
only fall.

A number that two rooms need stands in the lower one, what several say of rounding, decades and
deviations in `springpot.numerics`.
"""


def test_the_chain_of_imports_grows_no_longer():
    named = {
        package if path.stem == "__init__" else f"{package}.{path.stem}": (path, package)
        for path, package in FILES
    }
    edges = {
        name: names_of(facts(path).at_once, package) & named.keys() - {name}
        for name, (path, package) in named.items()
    }
    depth: dict[str, int] = {}
    for name in TopologicalSorter(edges).static_order():
        depth[name] = 1 + max((depth[below] for below in edges[name]), default=0)
    assert max(depth.values()) <= DEEPEST


def test_files_and_numbers_grow_no_more():
    """A further one asks whether a file of its idea, or a number that says it, is there already."""
    framework, plugins = (sum(len(facts(it).numbers) for it, _ in files) for files in (FILES, OWN))
    told = [(FRAMEWORK / name, each) for name, names in FACTS.items() for each in names.split()]
    assert [each for path, each in told if each not in facts(path).numbers] == []
    framework -= len(told)
    assert len(FILES) <= MODULES
    assert len(OWN) <= OF_PLUGINS
    assert framework <= NUMBERS
    assert framework + plugins <= WITH_PLUGINS


def test_only_who_draws_waits_for_matplotlib():
    """It takes as long to import as all else, and is an extra that may be missing."""
    drawing = [path for path, package in FILES if "matplotlib" in names_at_once(path, package)]
    assert drawing == []


def names_at_once(path: Path, package: str) -> set[str]:
    """What is imported as soon as a file is."""
    return {name.partition(".")[0] for name in names_of(facts(path).at_once, package)}


def test_a_measurement_needs_few_files():
    """So that a browser's Python or a reader's author need not load the framework for the data."""
    program = (
        "import sys; import springpot.measurement.measurement;"
        "print(sum(name.startswith('springpot.') for name in sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert int(done.stdout) <= 14


def test_no_more_names_of_classes_stand_for_two_things():
    names = [name for path, _ in FILES for name in facts(path).classes if not name.startswith("_")]
    assert sum(names.count(name) > 1 for name in set(names)) <= TWICE


def test_names_that_a_package_offers_are_no_files_of_it():
    """A file that was imported would stand in the place of the function of its name."""
    for path, _ in FILES:
        if path.name != "__init__.py" or "offered(" not in path.read_text(encoding="utf-8"):
            continue
        package = import_module(".".join(["springpot", *path.parent.relative_to(FRAMEWORK).parts]))
        files = {file.stem for file in path.parent.glob("*.py")}
        clash = [
            name
            for name in files & set(dir(package))
            if not isinstance(getattr(package, name), ModuleType)
        ]
        assert clash == []


def test_a_docstring_is_no_code():
    (function,) = ast.parse('def f(x):\n    """One.\n\n    Two.\n    """\n    return x\n').body
    assert isinstance(function, ast.FunctionDef)
    assert code_lines(function) == 2


def test_the_check_itself_sees_relative_and_hidden_imports(tmp_path: Path):
    path = tmp_path / "sly.py"
    path.write_text(
        "def f():\n    from ..cli import main\n    import springpot.report.text\n", encoding="utf-8"
    )
    assert rooms(imported(path, "springpot.rheology")) == {"cli", "report"}


@cache
def repository() -> tuple[Path, ...]:
    """Files under version control or about to be; an unpacked copy gives all of its own."""
    command = ["git", "ls-files", "-co", "--exclude-standard"]
    try:
        listed = subprocess.run(
            command, cwd=ROOT, capture_output=True, text=True, check=True
        ).stdout.splitlines()
    except (OSError, subprocess.CalledProcessError):
        folders = ("framework", "plugins", "studies", "tests", "results", "docs", ".ci")
        inside = [
            path
            for folder in folders
            for path in (ROOT / folder).rglob("*")
            if "__pycache__" not in path.parts
        ]
        return tuple(path for path in [*ROOT.glob("*.*"), *inside] if path.is_file())
    return tuple(path for name in listed if (path := ROOT / name).is_file())


MACHINE = re.compile(
    r"(?<![\w.~-])/(?:work|tmp|home|root|Users|mnt)/\w"  # absolute paths of one machine
    r"|\bfarm-\w|[.]library\b"  # tools of one workplace
    r"|\b(?:artifactory|nexus|devpi)\b|\bindex-url\b",  # hosts that packages come from
)
PARTS = (
    *("/work/", "/tmp/", "/home/", "/root/", "/Users/", "/mnt/"),
    *("farm-", ".library", "artifactory", "nexus", "devpi", "index-url"),
)
"""Of these the pattern needs one: to look for them first takes a twentieth of the time."""


def of_a_machine(text: str) -> list[str]:
    """What in a text belongs to one machine."""
    if not any(part in text for part in PARTS):
        return []
    return [found[0] for found in MACHINE.finditer(text)]


def test_no_file_names_a_machine():
    guilty = []
    for path in repository():
        if path == Path(__file__).resolve() or path.suffix in {
            ".png",
            ".pdf",
            ".sqlite",
            ".zip",
            ".gif",
        }:
            continue
        text = path.read_text(encoding="utf-8", errors="replace")
        guilty += [f"{path.relative_to(ROOT)}: {found}" for found in of_a_machine(text)]
    assert guilty == []


def test_no_file_is_half_merged():
    texts = {".md", ".py", ".toml", ".txt", ".yml", ".csv"}
    marks = re.compile(r"^(?:<{7}|>{7}) ", re.MULTILINE)
    guilty = [
        str(path.relative_to(ROOT))
        for path in repository()
        if path.suffix in texts and marks.search(path.read_text("utf-8", errors="replace"))
    ]
    assert guilty == []


@pytest.mark.parametrize(
    "text",
    [
        *("see /work/" + "main", "'/tmp/" + "x'", "farm-" + "run", "/home/" + "me"),
        *("/root/" + "x", "/Users/" + "me", "/mnt/" + "x", "." + "library"),
        *("an " + "artifactory", "ne" + "xus", "dev" + "pi", "--index-" + "url"),
    ],
)
def test_the_pattern_finds_machines(text: str):
    assert of_a_machine(text)


@pytest.mark.parametrize(
    "text", ["kN/m", "framework/springpot", "https://example.org/home/page", "tests/tmp/x"]
)
def test_the_pattern_lets_ordinary_text_pass(text: str):
    assert not of_a_machine(text)


def test_no_two_test_files_share_a_name():
    """pytest collects folders without `__init__.py` by bare module name.

    A second file of one name stops the run.
    """
    bare = [
        path
        for path in (ROOT / "tests").rglob("*.py")
        if not (path.parent / "__init__.py").exists()
    ]
    names = [path.stem for path in bare if path.stem != "conftest"]
    assert sorted(names) == sorted(set(names))
