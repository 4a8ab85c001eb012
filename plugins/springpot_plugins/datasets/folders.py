r"""Data sets in folders of the directories that the environment variable SPRINGPOT_DATA names.

Their manifests, ``dataset.toml``, say what the columns of a folder's file mean, and who measured
them::

    summary = "what was measured"               # one sentence
    file = "normalized.csv"                     # or [files], below
    open = "#1?frequency=1[Hz]"                 # what a user would type behind its name; not
                                                # with [columns]
    size = 340                                  # rows, shown before loading
    citation = "who"                            # who measured, where it was published
    doi = "10.1000/xyz"                         # optional, as all that follow
    origin = "github.com/who/what"              # where it can be got
    licence = "MIT"
    test = "8 mm plates, shear"                 # instrument, geometry, kind of test
    accuracy = "1%,3mrad"                       # what the instrument promises
    physics = ["what is known to be in it"]
    model = "fractional-maxwell"                # used in the literature
    fit = "G = 1 kPa, tau = 2 s (who)"          # what was found with it

    [columns]                                   # role = "header" or { from, unit }
    omega = { from = "omega_rad_s", unit = "rad/s" }
    storage = { from = "storage_Pa", unit = "Pa" }
    loss = { from = "loss_Pa", unit = "Pa" }
    temperature = { from = "temperature_C", unit = "degC" }
    lane = { from = "binder", extract = 'Lane (\d+)' }  # a pattern picks a part of the cell

    [conditions]                                # constants, with their units as in headers
    "temperature [degC]" = 25

    [files]                                     # instead of file: each with its own constants
    "at20.csv" = { "temperature [degC]" = 20 }
    "at40.csv" = { "temperature [degC]" = 40 }

    [download]                                  # the file's public address, where the licence
    url = "https://example.org/normalized.csv"  # allows
    sha256 = "..."                              # of the file there

A manifest is limited: `MANIFEST.largest` bytes, names of files as `is_name`, patterns as in
`patterns`, texts of `MANIFEST.text` signs, addresses with https. It stands in the folder that it
describes. For the folders that this package knows by name, it is shipped. Without [columns], and
where a downloaded file has another name than `file`, the reader of its format opens it.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from importlib.resources import files
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

from springpot.errors import LONGEST_REASON, DataError
from springpot.measurement import (
    PROMISED,
    Choice,
    DataSet,
    Measurement,
    Reader,
    open_measurement,
    toml_of,
    within_budget,
)

from ..readers import springpot_readers
from ..readers.columns import ROLES, measurement_of
from ..readers.grid import text_of
from ..readers.joining import joined
from ..readers.table import Column, ParsedTable, name_and_unit, table_of
from .download import fetched, file_name, inside, is_name, kept, missing

FILE = "dataset.toml"


class Limits(NamedTuple):
    """What a manifest may hold: somebody else has written it."""

    largest: int
    """Bytes of a manifest; the shipped ones have two thousand."""
    text: int
    columns: int
    files: int
    """Files of one set: a rig that sweeps a hundred temperatures is rare, and each has to be
    opened.
    """
    size: int
    """Rows that are believed."""
    cell: int
    """Signs of a cell that are searched."""
    pattern: int
    choices: int
    """Repetitions and alternatives in a pattern.

    With as many, the worst search of a cell takes about a second.
    """


MANIFEST = Limits(
    largest=1 << 14, text=2000, columns=400, files=100, size=10**12, cell=80, pattern=100, choices=4
)
_TEXTS = (
    "name",
    "summary",
    "file",
    "open",
    "citation",
    "doi",
    "origin",
    "licence",
    "test",
    "model",
    "fit",
    "kind",
    "accuracy",
)
_ONE_SIGN = re.compile(r"\\.|\[\^?\]?(?:\\.|[^\]\\])*\]")
"""An escape or a class, which match one sign."""


@dataclass(frozen=True)
class Manifest:
    """The content of a ``dataset.toml``, checked.

    Parameters
    ----------
    folder : Path
        Where the data file is.
    values : mapping
        Names, texts, size and physics as in the file.
    columns : mapping of str to mapping
        Role or condition to ``from``, ``unit`` and ``extract``; empty where the reader of the
        format names them.
    conditions : mapping of str to number
        Constants.
    download : mapping of str to str
        ``url`` and ``sha256``; empty where the file cannot be downloaded.
    files : mapping of str to mapping
        Names of the files to the constants of each; the one file where there is but one.
    """

    folder: Path
    values: dict[str, Any]
    columns: dict[str, dict[str, str]]
    conditions: dict[str, float] = field(default_factory=dict)
    download: dict[str, str] = field(default_factory=dict)
    files: dict[str, dict[str, float]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the set: as given, or the folder's."""
        return str(self.values.get("name", self.folder.name))

    @property
    def paths(self) -> dict[Path, dict[str, float]]:
        """Where the files are, if they are here, and the constants of each.

        Raises
        ------
        DataError
            If one would be outside the folder.
        """
        return {
            inside(self.folder, name): {**self.conditions, **own}
            for name, own in self.files.items()
        }

    @property
    def _missing(self) -> list[Path]:
        return [path for path in self.paths if not path.is_file()]

    def dataset(self) -> DataSet:
        """The set; its file is opened only when it is loaded."""
        value = self.values.get
        columns = [_titled(name, source.get("unit")) for name, source in self.columns.items()]
        constants = [f"{title} = {number:g}" for title, number in self.conditions.items()]
        constants += list(dict.fromkeys(title for own in self.files.values() for title in own))
        return DataSet(
            self.name,
            value("summary", ""),
            self.load,
            kind=value("kind", "measured"),
            licence=value("licence", ""),
            citation=value("citation", ""),
            doi=value("doi", ""),
            origin=value("origin", ""),
            size=value("size", 0),
            model=value("model", ""),
            fit=value("fit", ""),
            test=value("test", ""),
            columns=(*(columns or ["as the file names them"]), *constants),
            physics=tuple(value("physics", ())),
            remote=self._remote(),
            unavailable=self._unavailable(),
        )

    def _remote(self) -> str:
        """The address, unless the file is here or has been downloaded."""
        # A file that is here goes before its copy elsewhere: no connection is needed then.
        if (
            not self.download
            or not self._missing
            or kept(self.download["url"], self.download["sha256"])
        ):
            return ""
        return self.download["url"]

    def _unavailable(self) -> str:
        if not self._missing:
            return ""
        if self.download and not self._remote():
            return ""
        if self.download:
            return missing()
        if self.folder.is_dir():
            return f"{self._missing[0]} is missing"
        origin = ""
        if self.values.get("origin"):
            origin = f"published at {self.values['origin']}; "
        return (
            f"not here: {origin}name a directory that holds the folder {self.name} by"
            " SPRINGPOT_DATA"
        )

    def load(self) -> Measurement:
        """The measurement.

        Raises
        ------
        DataError
            If a file cannot be had or read, or lacks a column that the manifest names.
        """
        # A folder of the user's wins over the download.
        if self.download and self._missing:
            path = fetched(self.name, self.download["url"], self.download["sha256"])
            # A download of another name has columns of its own, which the manifest does not
            # describe.
            parts = [self._opened(path, self.conditions, path.name in self.files)]
        else:
            parts = [self._opened(path, constants, True) for path, constants in self.paths.items()]
        origin = {
            key: str(self.values[key])
            for key in ("citation", "doi", "licence")
            if self.values.get(key)
        }
        if self.values.get("accuracy"):
            origin[PROMISED] = str(self.values["accuracy"])
        whole = parts[0]
        if len(parts) > 1:
            whole = joined(parts, list(self.files), self.name, f"{len(parts)} files together")
        return replace(whole, name=self.name, provenance={**origin, **whole.provenance})

    def _opened(self, path: Path, constants: dict[str, float], described: bool) -> Measurement:
        """One file: by the columns that the manifest names, or by the reader of its format."""
        if not described:
            return open_measurement(path, (), springpot_readers())
        if not self.columns:
            spec = _with_constants(f"{path}{self.values.get('open', '')}", constants)
            return open_measurement(spec, (), springpot_readers())

        def read(path: Path, choice: Choice) -> Measurement:
            return self._read(path, constants)

        # As a reader of its own, so that the limits of time and memory of opening hold for it too.
        return open_measurement(
            path, (), [Reader(self.name, "the columns of a manifest", lambda head: 1.0, read)]
        )

    def _read(self, path: Path, constants: dict[str, float]) -> Measurement:
        """The table, by the columns that the manifest names."""
        table = table_of(text_of(path))
        made = [*self._mapped(table), *_constants(constants, table)]
        roles = {column.name: column for column in made if column.name in ROLES}
        others = [column for column in made if column.name not in ROLES]
        return measurement_of(roles, others, self.name, table.comments)

    def _mapped(self, table: ParsedTable) -> Iterable[Column]:
        by_title = {column.title: column for column in table.columns}
        for name, source in self.columns.items():
            title = source["from"]
            if title not in by_title:
                raise DataError(f"no column '{title}', which the manifest of {self.name} names")
            column = by_title[title]
            cells = column.cells
            if pattern := source.get("extract"):
                cells = [picked(pattern, cell) for cell in cells]
            unit = source.get("unit", column.unit)
            yield Column(title, name, unit, cells, column.lines, column.decimal_comma)


def _constants(values: dict[str, float], table: ParsedTable) -> Iterable[Column]:
    first = table.columns[0]
    for title, value in values.items():
        name, unit = name_and_unit(title)
        yield Column(title, name, unit, [repr(float(value))] * len(first.cells), first.lines)


def _with_constants(spec: str, values: dict[str, float]) -> str:
    """What a user would type to say the constants as well: ``FILE?temperature=20[degC]``."""
    titles = {title: name_and_unit(title) for title in values}
    constants = ",".join(
        f"{name}={values[title]!r}[{unit or '-'}]" for title, (name, unit) in titles.items()
    )
    if not constants:
        return spec
    if "?" in spec:
        # The manifest's own "open" has options already.
        return f"{spec},{constants}"
    return f"{spec}?{constants}"


def read_manifest(text: str, folder: Path, path: str) -> Manifest:
    """The manifest that a text holds.

    Raises
    ------
    DataError
        If it is no TOML, or an entry is missing, of the wrong kind or beyond its limit.
    """
    # Before it is parsed: whoever writes a manifest may write one that takes long.
    if len(text) > MANIFEST.largest:
        raise DataError(f"{path}: a manifest of more than {MANIFEST.largest >> 10} KiB")
    try:
        values = toml_of(text)
    except ValueError as error:
        raise DataError(f"{path}: {error}") from None
    columns = values.pop("columns", {})
    constants = values.pop("conditions", {})
    files = values.pop("files", {})
    download = values.pop("download", {})
    if not isinstance(columns, dict):
        raise DataError(
            f"{path}: [columns] is a table; write omega, storage, loss = {{ from, unit }}"
        )
    if len(columns) > MANIFEST.columns:
        raise DataError(f"{path}: more than {MANIFEST.columns} columns")
    mapped = {}
    for name, source in columns.items():
        entry = source
        if isinstance(source, str):
            # The short form: role = "header".
            entry = {"from": source}
        if not (
            isinstance(entry, dict)
            and "from" in entry
            and all(isinstance(v, str) for v in entry.values())
        ):
            raise DataError(
                f"{path}: column '{name}' needs from = \"header\", and unit or extract as text"
            )
        if "extract" in entry:
            try:
                checked(entry["extract"])
            except DataError as error:
                raise DataError(f"{path}: the pattern of column '{name}' {error}") from None
        mapped[name] = entry
    if not (isinstance(constants, dict) and all(map(_is_number, constants.values()))):
        raise DataError(f"{path}: [conditions] holds finite numbers only")
    _check_files(files, values, path)
    _check_values(values, path)
    _check_download(download, values, path)
    return Manifest(folder, values, mapped, constants, download, files or {values["file"]: {}})


def _check_files(files: Any, values: dict[str, Any], path: str) -> None:
    """Either one file or several, whose constants are numbers."""
    if bool(files) == ("file" in values):
        raise DataError(
            f'{path}: there is no file = "name.csv", or [files] beside it; give one of the two'
        )
    if not isinstance(files, dict) or len(files) > MANIFEST.files:
        raise DataError(f"{path}: [files] is a table of at most {MANIFEST.files} names")
    if not all(
        isinstance(own, dict) and all(map(_is_number, own.values())) for own in files.values()
    ):
        raise DataError(
            f'{path}: [files] holds "name.csv" = {{ "temperature [degC]" = 20 }}, with numbers only'
        )


def _check_download(download: Any, values: dict[str, Any], path: str) -> None:
    if download == {}:
        return
    if not (isinstance(download, dict) and set(download) == {"url", "sha256"}):
        raise DataError(f"{path}: [download] holds url and sha256, and nothing else")
    url, sha256 = str(download["url"]), str(download["sha256"])
    try:
        file_name(url)
    except DataError as error:
        raise DataError(f"{path}: [download]: {error}") from None
    if not re.fullmatch(r"[0-9a-f]{64}", sha256):
        raise DataError(f"{path}: [download] needs a sha256 of 64 hexadecimal digits")
    if not values.get("licence"):
        raise DataError(f'{path}: [download] needs a licence that allows it; write licence = "..."')


def _titled(name: str, unit: str | None) -> str:
    """A column with its unit, where it has one."""
    if not unit:
        return name
    return f"{name} [{unit}]"


def _is_number(value: object) -> bool:
    """Whether a value is a number that a float can hold."""
    try:
        # True and False are whole numbers to Python, and to nobody else.
        return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
    except OverflowError:
        return False


def _check_values(values: dict[str, Any], path: str) -> None:
    wrong = [key for key in _TEXTS if not _is_text(values.get(key, ""))]
    unknown = [key for key in values if key not in (*_TEXTS, "size", "physics")]
    if wrong or unknown:
        raise DataError(
            f"{path}: check {', '.join(wrong or unknown)}; known are {', '.join(_TEXTS)}, size,"
            " physics"
        )
    if not is_name(values.get("name", "name")):
        raise DataError(f"{path}: '{values['name']:.80}' is no name of a data set")
    size, physics = values.get("size", 0), values.get("physics", [])
    if not (isinstance(size, int) and 0 <= size <= MANIFEST.size):
        raise DataError(f"{path}: size is the number of rows")
    if not (isinstance(physics, list) and all(map(_is_text, physics))):
        raise DataError(f"{path}: physics is a list of sentences")


def _is_text(value: object) -> bool:
    return isinstance(value, str) and len(value) <= MANIFEST.text


def checked(pattern: str) -> str:
    """`pattern`, if it has one group and its search cannot take for ever.

    Each repetition may end anywhere, so a search takes a power of the cell's length: with few of
    them that is little. Repeated groups, references and assertions, whose search may grow without
    such a bound, are not taken.

    Raises
    ------
    DataError
        If it has not.
    """
    if len(pattern) > MANIFEST.pattern:
        raise DataError(f"has more than {MANIFEST.pattern} signs")
    if re.search(r"\\[1-9]|\(\?", pattern):
        raise DataError("has a reference or (?...), which are not taken")
    # Without escapes and classes, whose signs repeat nothing, and with lazy repetitions as plain
    # ones.
    bare = re.sub(r"([*+?}])[?+]", r"\1", _ONE_SIGN.sub("x", pattern))
    if re.search(r"\)[*+?{]", bare):
        raise DataError("repeats a group, which is not taken")
    if len(re.findall(r"[*+?{|]", bare)) > MANIFEST.choices:
        raise DataError(f"has more than {MANIFEST.choices} of * + ? {{ |")
    try:
        groups = re.compile(pattern).groups
    except (re.error, OverflowError) as error:
        raise DataError(f"is wrong: {error}") from None
    if groups != 1:
        raise DataError("needs one group in parentheses")
    return pattern


def picked(pattern: str, cell: str) -> str:
    """What the group of a checked pattern finds in a cell; nothing where it is not there."""
    match = re.search(pattern, cell[: MANIFEST.cell])
    if match is None:
        return ""
    # A group that took no part in the match is None.
    return match[1] or ""


VARIABLE = "SPRINGPOT_DATA"
NOWHERE = Path(os.devnull)
"""Stands for the directory of a set that is not on this machine."""


def datasets() -> list[DataSet]:
    """A set for every folder with a manifest, of its own or shipped.

    Also for every shipped manifest that has no folder. The first of a name counts.
    """
    sets: dict[str, DataSet] = {}
    for folder in (*_folders(), *_known()):
        dataset = _dataset(folder)
        if dataset is not None:
            # Folders before what is shipped, in the order of the directories: a user's own goes
            # first.
            sets.setdefault(dataset.name, dataset)
    return list(sets.values())


def _known() -> Iterator[Path]:
    """Folders that would hold the sets of the shipped manifests, and need not be there."""
    shipped = files(__package__).joinpath("manifests").iterdir()
    yield from sorted(
        NOWHERE / entry.name.removesuffix(".toml")
        for entry in shipped
        if entry.name.endswith(".toml")
    )


def _folders() -> Iterator[Path]:
    """Every directory itself, if it has a manifest, and its folders in the order of their names."""
    for directory in filter(None, os.environ.get(VARIABLE, "").split(os.pathsep)):
        root = Path(directory).expanduser()
        try:
            if (root / FILE).is_file():
                yield root
            yield from sorted(entry for entry in root.iterdir() if entry.is_dir())
        except OSError:
            # A directory that is not there holds nothing; the listing must not fail for it.
            continue


def _dataset(folder: Path) -> DataSet | None:
    """The set of a folder; unavailable, with the reason, where its manifest is wrong."""
    try:
        if (folder / FILE).is_file():
            own = inside(folder, FILE)
            return within_budget(own, lambda: read_manifest(_text(own), folder, str(own)).dataset())
        shipped = files(__package__).joinpath("manifests", f"{folder.name}.toml")
        if shipped.is_file():
            return read_manifest(
                shipped.read_text(encoding="utf-8"), folder, shipped.name
            ).dataset()
    except DataError as error:
        return _broken(folder, str(error))
    except Exception as error:
        # Whatever a stranger writes there, it must not take the other sets away.
        return _broken(folder, f"{folder / FILE}: {type(error).__name__}: {error}")
    return None


def _text(path: Path) -> str:
    """A manifest, or as much of it as is enough to see that it is too large."""
    with path.open("rb") as stream:
        return stream.read(MANIFEST.largest + 1).decode("utf-8")


def _broken(folder: Path, reason: str) -> DataSet:
    reason = " ".join(reason.split())[:LONGEST_REASON]

    def load() -> Measurement:
        raise DataError(f"data set '{folder.name}' is unavailable: {reason}")

    return DataSet(folder.name, "its manifest cannot be used", load, unavailable=reason)
