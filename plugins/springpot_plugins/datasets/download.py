"""Data sets from their public origin: fetched once, checked against a checksum, kept in the user's cache."""

from __future__ import annotations

import hashlib
import os
from importlib.util import find_spec
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, urlparse

from springpot.errors import DataError

CACHE = "SPRINGPOT_CACHE"
"""Environment variable that names another place for downloads."""
INSTALL = "pip install 'springpot[download]'"


def missing() -> str:
    """What keeps this machine from downloading, or nothing."""
    return "" if find_spec("pooch") else f"it is downloaded by pooch, which is not installed: {INSTALL}"


def place(url: str, sha256: str) -> Path:
    """Where a download is kept; the checksum in the path keeps two versions of one name apart."""
    cache = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = os.environ.get(CACHE) or Path(cache) / "springpot"
    return Path(folder) / sha256[:16] / (unquote(PurePosixPath(urlparse(url).path).name) or "data")


def kept(url: str, sha256: str) -> bool:
    """Whether the file has been downloaded, as it was published."""
    path = place(url, sha256)
    return path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() == sha256


def fetched(name: str, url: str, sha256: str) -> Path:
    """The file at an address; downloaded if it is not here yet.

    Parameters
    ----------
    name : str
        The data set, for errors.
    url : str
        Address of the file, http or https.
    sha256 : str
        Of its content, in hexadecimal.

    Raises
    ------
    DataError
        If pooch is not installed, there is no connection, or the content is not what was published.
    """
    path = place(url, sha256)
    if kept(url, sha256):
        return path
    try:
        import pooch
    except ImportError:
        raise DataError(f"data set '{name}': {missing()}") from None
    pooch.get_logger().setLevel("ERROR")
    try:
        pooch.retrieve(url, known_hash=f"sha256:{sha256}", fname=path.name, path=path.parent)
    except ValueError:
        raise DataError(
            f"data set '{name}': what {url} holds is not what was published (its checksum differs); nothing was kept"
        ) from None
    except OSError as error:
        raise DataError(
            f"data set '{name}' cannot be downloaded from {url}: {_reason(error)}; "
            "with a connection it is fetched once, or name a folder that has it by SPRINGPOT_DATA"
        ) from None
    return path


def _reason(error: OSError) -> str:
    """The errors of connections are long and nested; their kind says enough."""
    status = getattr(getattr(error, "response", None), "status_code", None)
    if status is not None:
        return f"the server answers {status}"
    kinds = {"ConnectionError": "no connection", "ConnectTimeout": "no answer", "ReadTimeout": "no answer"}
    kinds |= {"ChunkedEncodingError": "the connection broke off"}
    return kinds.get(type(error).__name__) or error.strerror or type(error).__name__
