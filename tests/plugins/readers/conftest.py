"""A folder in which files of any content are opened by the built-in readers."""

import pytest

from springpot.errors import DataError
from springpot.measurement import open_measurement, parts_of, pick_reader
from springpot_plugins.readers import springpot_readers

READERS = tuple(springpot_readers())


class Folder:
    """Files of given content, opened as a user would."""

    def __init__(self, path):
        self.path = path

    def write(self, content, name="data.txt"):
        path = self.path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    def open(self, content, said="", name="data.txt"):
        return open_measurement(f"{self.write(content, name)}{said}", (), READERS)

    def complaint(self, content):
        """What is said against a file; any error but a DataError is a crash."""
        try:
            assert len(self.open(content)) > 0
        except DataError as error:
            return str(error)
        return ""

    def reader(self, content, name="data.txt"):
        return pick_reader(self.write(content, name), READERS).name

    def parts(self, content, name="data.txt"):
        return parts_of(self.write(content, name), READERS)


@pytest.fixture
def folder(tmp_path):
    return Folder(tmp_path)
