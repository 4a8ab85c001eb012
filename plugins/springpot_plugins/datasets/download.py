"""Data sets from their public origin.

Fetched once, checked against a checksum, kept in the user's cache. Names that others choose for
files and data sets: which are taken, and that a file lies where its name says.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path, PurePosixPath
from shutil import copyfileobj
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import unquote, urljoin, urlparse

from springpot.errors import DataError

_NAME = re.compile(r"\w(?:[\w.+=,() -]{0,98}[\w)])?")
"""Letters and digits of any language, and signs without a meaning to file systems and shells."""


def is_name(text: str) -> bool:
    """Whether this may name a file or a data set."""
    return _NAME.fullmatch(text) is not None


def inside(folder: Path, name: str) -> Path:
    """The file of that name in `folder`; parts of a name are joined by ``/``.

    Raises
    ------
    DataError
        If the name has other signs than those allowed, or leads out of the folder, by a link too.
    """
    parts = name.split("/")
    if not all(map(is_name, parts)):
        raise DataError(
            f"'{name:.80}' names no file: use letters, digits and . _ + - = , ( ) and blanks"
        )
    path = folder.joinpath(*parts)
    # Resolved, since a link within the folder may lead anywhere. One that leads to itself stays,
    # and opens nothing.
    if not Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder)):
        raise DataError(f"{path} leads out of its folder; put the file itself there")
    return path


CACHE = "SPRINGPOT_CACHE"
"""Environment variable that names another place for downloads."""
INSTALL = "pip install 'springpot[download]'"
LARGEST = 1 << 30
"""Bytes of a download, since a server may send without end.

A file as large as that is allowed ten times its size of
memory to be read in (`springpot.files`): few machines could use a larger one."""


def missing() -> str:
    """What keeps this machine from downloading, or nothing."""
    # Looked for, not imported: the listing of all sets asks this, and must stay quick.
    if find_spec("pooch"):
        return ""
    return f"it is downloaded by pooch, which is not installed: {INSTALL}"


def file_name(url: str) -> str:
    """The name of the file at an address.

    Raises
    ------
    DataError
        If the address is no https, or its last part, once unquoted, is no name of a file.
    """
    try:
        parts = urlparse(url)
        host = parts.hostname
    except ValueError:
        host = None
    if not host or parts.scheme != "https":
        raise DataError(f"'{url:.80}' is no address with https://")
    name = unquote(PurePosixPath(parts.path).name)
    if not is_name(name):
        raise DataError(f"the last part of '{url:.80}' names no file")
    return name


def place(url: str, sha256: str) -> Path:
    """Where a download is kept; the checksum in the path keeps two versions of one name apart.

    Raises
    ------
    DataError
        If that is no place in the cache.
    """
    # Where the XDG Base Directory Specification puts what can be had again.
    cache = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(os.environ.get(CACHE) or Path(cache) / "springpot")
    return inside(folder, f"{sha256[:16]}/{file_name(url)}")


def kept(url: str, sha256: str) -> bool:
    """Whether the file has been downloaded, as it was published."""
    return _is(place(url, sha256), sha256)


def _is(path: Path, sha256: str) -> bool:
    """Whether a file has that content."""
    if not path.is_file():
        return False
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest() == sha256


def fetched(name: str, url: str, sha256: str) -> Path:
    """The file at an address; downloaded if it is not here yet.

    Parameters
    ----------
    name : str
        The data set, for errors.
    url : str
        Address of the file, https.
    sha256 : str
        Of its content, in hexadecimal.

    Raises
    ------
    DataError
        If pooch is not installed, there is no connection, the content is not what was published, or
        another file is in its place.
    """
    path = place(url, sha256)
    if _in_place(name, path, sha256):
        return path
    try:
        import pooch
    except ImportError:
        raise DataError(f"data set '{name}': {missing()}") from None
    # What it would print of its progress belongs to no output of a command.
    pooch.get_logger().setLevel("ERROR")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # Beside its place, so that it gets there by a link: whoever looks sees the whole file or
        # none.
        with TemporaryDirectory(dir=path.parent, prefix=".download-") as draft:
            safely = pooch.HTTPDownloader(hooks={"response": _stay_safe})
            got = pooch.retrieve(
                url, f"sha256:{sha256}", fname=path.name, path=draft, downloader=safely
            )
            _put(Path(got), path)
    except FileExistsError:
        # Another process was quicker. Nothing is ever replaced: what it put there is used if it is
        # the same.
        if not _in_place(name, path, sha256):
            raise DataError(f"data set '{name}': {path.parent} is no folder; remove it") from None
    except ValueError:
        # Pooch says so of a wrong checksum.
        raise DataError(
            f"data set '{name}': what {url} holds is not what was published (its checksum differs);"
            " nothing was kept"
        ) from None
    except OSError as error:
        raise DataError(
            f"data set '{name}' cannot be downloaded from {url}: {_reason(error)}; "
            "with a connection it is fetched once, or name a folder that has it by SPRINGPOT_DATA"
        ) from None
    return path


def _in_place(name: str, path: Path, sha256: str) -> bool:
    """Whether the file is in its place already.

    Raises
    ------
    DataError
        If anything else is there, since nothing is ever replaced.
    """
    # In this order: a file that another process puts there meanwhile is the right one, and no
    # obstacle.
    if not (path.exists() or path.is_symlink()):
        return False
    if not _is(path, sha256):
        raise DataError(
            f"data set '{name}': {path} holds something else than what was published, and is not"
            " replaced; remove it, and it is downloaded again"
        )
    return True


def _put(draft: Path, path: Path) -> None:
    """Let the file appear whole in its place; an error where something is there already."""
    try:
        os.link(draft, path)
    except FileExistsError:
        # An OSError as well, but not for want of links.
        raise
    except OSError:
        # Not every file system has hard links.
        with draft.open("rb") as source, path.open("xb") as stream:
            try:
                copyfileobj(source, stream)
            except BaseException:
                # Half a file would stand in the way of the whole one for ever.
                path.unlink()
                raise


def _stay_safe(response: Any, *_: Any, **__: Any) -> None:
    """Follow no redirection away from https, and take no file without end."""
    if (
        response.is_redirect
        and urlparse(urljoin(response.url, response.headers["location"])).scheme != "https"
    ):
        raise OSError(0, "it leads to an address without https")
    pieces = response.iter_content

    def counted(*given: Any, **named: Any) -> Iterator[bytes]:
        received = 0
        # Counted as they come: what a server says of the length beforehand need not be so.
        for piece in pieces(*given, **named):
            received += len(piece)
            if received > LARGEST:
                raise OSError(0, f"it is larger than {LARGEST >> 20} MiB")
            yield piece

    response.iter_content = counted


def _reason(error: OSError) -> str:
    """The errors of connections are long and nested; their kind says enough."""
    status = getattr(getattr(error, "response", None), "status_code", None)
    if status is not None:
        return f"the server answers {status}"
    kinds = {
        "ConnectionError": "no connection",
        "ConnectTimeout": "no answer",
        "ReadTimeout": "no answer",
    }
    kinds |= {
        "ChunkedEncodingError": "the connection broke off",
        "SSLError": "its certificate is not trusted",
    }
    return kinds.get(type(error).__name__) or error.strerror or type(error).__name__
