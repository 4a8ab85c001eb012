"""A manifest is a stranger's word.

It reads and writes nothing outside its folder, and spoils no other data set.
"""

import os
from importlib.metadata import entry_points

import pytest

from springpot.errors import DataError
from springpot.hooks import GROUP
from springpot.registry import Registry
from springpot_plugins.datasets import folders, springpot_datasets
from springpot_plugins.datasets.download import inside, is_name
from springpot_plugins.datasets.folders import checked, picked

GOOD = """
summary = "a damper"
file = "raw.csv"
[columns]
frequency = { from = "f", unit = "Hz" }
storage = { from = "Ks", unit = "kN/m" }
loss = { from = "Kl", unit = "kN/m" }
what = { from = "what", extract = 'lane (\\w+)' }
"""
TABLE = "f,Ks,Kl,what\n1,2,3,lane a\n2,3,4,lane b\n"
NESTED = "x = " + "[" * 5000 + "]" * 5000
HOSTILE = {
    "nested": (NESTED, "nested too deeply"),
    "nested-tables": ("[" + ".".join("a" * 8000) + "]", "nested too deeply"),
    "huge-size": (f"size = {'9' * 400}{GOOD}", "size is the number of rows"),
    "huge-number": (f"size = {'9' * 5000}{GOOD}", "."),
    "huge-condition": (f'{GOOD}\n[conditions]\n"amplitude [mm]" = {"9" * 400}', "finite number"),
    "infinite-condition": (f'{GOOD}\n[conditions]\n"amplitude [mm]" = inf', "finite number"),
    "true-condition": (f'{GOOD}\n[conditions]\n"amplitude [mm]" = true', "finite number"),
    "exponential": (GOOD.replace("lane (\\w+)", "((a+)+)+$"), "which is not taken|one group"),
    "backtracking": (GOOD.replace("lane (\\w+)", "(a+)+$"), "repeats a group"),
    "polynomial": (GOOD.replace("lane (\\w+)", "a*a*a*a*a*a*(b)"), "more than 4"),
    "optional": (GOOD.replace("lane (\\w+)", "a?" * 20 + "(a)"), "more than 4"),
    "reference": (GOOD.replace("lane (\\w+)", "(a*)\\1*b"), "reference"),
    "long-pattern": (GOOD.replace("lane (\\w+)", "(" + "a" * 300 + ")"), "more than 100 signs"),
    "large": (GOOD + "#" * 100_000, "more than 16 KiB"),
    "long-text": (GOOD.replace("a damper", "x" * 3000), "check summary"),
    "wide": (GOOD + "".join(f'c{i} = "x"\n' for i in range(1000)), "more than 400 columns"),
    "not-unicode": (b"\xff\xfe\x00", "."),
    "physics": (f"physics = [[1], 2]{GOOD}", "physics is a list"),
    "named": (f'name = "\\u001b[2J"{GOOD}', "no name of a data set"),
    "above": (GOOD.replace("raw.csv", "../../mine.csv"), "names no file"),
    "absolute": (GOOD.replace("raw.csv", "/etc/hostname"), "names no file"),
    "windows": (GOOD.replace("raw.csv", "C:\\\\mine.csv"), "names no file"),
    "files-above": ('[files]\n"../../mine.csv" = {}\n', "names no file"),
    "many-files": ("[files]\n" + "".join(f'"{i}.csv" = {{}}\n' for i in range(500)), "at most 100"),
    "hidden": (GOOD.replace("raw.csv", ".ssh/id"), "names no file"),
}


@pytest.fixture
def directory(tmp_path, monkeypatch):
    """A directory with one good set, and something outside it."""
    (tmp_path / "mine.csv").write_text(TABLE)
    root = tmp_path / "data"
    (root / "good").mkdir(parents=True)
    (root / "good" / "raw.csv").write_text(TABLE)
    (root / "good" / "dataset.toml").write_text(GOOD)
    monkeypatch.setenv(folders.VARIABLE, str(root))
    return root


def add(directory, name, manifest):
    (directory / name).mkdir()
    (directory / name / "raw.csv").write_text(TABLE)
    content = manifest if isinstance(manifest, bytes) else manifest.encode()
    (directory / name / "dataset.toml").write_bytes(content)


def found():
    return {dataset.name: dataset for dataset in folders.datasets()}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_manifest_is_unavailable_with_its_reason_and_spoils_nothing(directory, name):
    manifest, reason = HOSTILE[name]
    add(directory, name, manifest)
    sets = found()
    assert sets[name].where == "missing"
    assert "\n" not in sets[name].unavailable
    with pytest.raises(DataError, match=reason):
        sets[name].open()
    assert len(sets["good"].open()) == 2
    assert "nist-srm2491" in {dataset.name for dataset in springpot_datasets()}


def test_all_at_once_are_listed_and_the_registry_has_no_fault(directory):
    for name, (manifest, _) in HOSTILE.items():
        add(directory, name, manifest)
    for i in range(50):
        add(directory, f"many-{i}", GOOD)
    assert {*HOSTILE, "good", "many-49"} <= found().keys()
    registry = Registry(entry_points(group=GROUP))
    assert {*HOSTILE, "good"} <= set(registry.names("data set"))
    assert not [fault for fault in registry.faults if "datasets" in fault.plugin]


def test_a_link_out_of_the_folder_is_not_followed(directory):
    add(directory, "linked", GOOD)
    (directory / "linked" / "raw.csv").unlink()
    (directory / "linked" / "raw.csv").symlink_to(directory.parent / "mine.csv")
    with pytest.raises(DataError, match="leads out of its folder"):
        found()["linked"].open()


def test_nor_is_one_by_way_of_a_folder_or_of_the_manifest_itself(directory):
    add(directory, "by-folder", GOOD.replace("raw.csv", "more/mine.csv"))
    (directory / "by-folder" / "more").symlink_to(directory.parent)
    add(directory, "by-manifest", GOOD)
    (directory / "by-manifest" / "dataset.toml").unlink()
    (directory.parent / "other.toml").write_text(GOOD)
    (directory / "by-manifest" / "dataset.toml").symlink_to(directory.parent / "other.toml")
    for name in ("by-folder", "by-manifest"):
        with pytest.raises(DataError, match="leads out of its folder"):
            found()[name].open()


def test_a_link_within_the_folder_and_a_linked_folder_serve(directory):
    add(directory, "within", GOOD.replace("raw.csv", "newest.csv"))
    (directory / "within" / "newest.csv").symlink_to("raw.csv")
    (directory.parent / "elsewhere").mkdir()
    add(directory.parent / "elsewhere", "far", GOOD)
    (directory / "far").symlink_to(directory.parent / "elsewhere" / "far")
    assert len(found()["within"].open()) == len(found()["far"].open()) == 2


def test_a_link_that_leads_to_itself_is_a_file_that_is_missing(directory):
    for name in ("file", "manifest"):
        (directory / name).mkdir()
    (directory / "file" / "dataset.toml").write_text(GOOD)
    (directory / "file" / "raw.csv").symlink_to("raw.csv")
    (directory / "manifest" / "dataset.toml").symlink_to("dataset.toml")
    found = {dataset.name: dataset for dataset in folders.datasets()}
    assert found["file"].unavailable.endswith("raw.csv is missing")
    assert "manifest" not in found
    assert len(found["good"].open()) == 2


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
def test_a_pipe_is_waited_for_nowhere(directory):
    (directory / "piped").mkdir()
    os.mkfifo(directory / "piped" / "dataset.toml")
    add(directory, "file-is-a-pipe", GOOD)
    (directory / "file-is-a-pipe" / "raw.csv").unlink()
    os.mkfifo(directory / "file-is-a-pipe" / "raw.csv")
    sets = found()
    assert "piped" not in sets
    with pytest.raises(DataError, match=r"raw\.csv is missing"):
        sets["file-is-a-pipe"].open()


@pytest.mark.parametrize(
    "name",
    [
        "",
        ".",
        "..",
        ".a",
        "a/b",
        "a\\b",
        "a\0b",
        "a\nb",
        "\x1b[2J",
        "a:b",
        "a ",
        "a.",
        "-rf",
        "~",
        "x" * 200,
    ],
)
def test_names_that_are_not_taken(name, tmp_path):
    assert not is_name(name)
    with pytest.raises(DataError, match="names no file"):
        inside(tmp_path, f"sub/{name}/..")


@pytest.mark.parametrize(
    "name", ["a", "normalized.csv", "Messung 3 (neu).csv", "Dämpfer.txt", "run=1,f+2.csv"]
)
def test_names_that_are(name, tmp_path):
    assert is_name(name)
    assert inside(tmp_path, f"sub/{name}") == tmp_path / "sub" / name


def test_the_costliest_pattern_that_is_taken_ends_soon():
    """Four repetitions in a row, which find nothing.

    Some million steps, where nested ones would take 2^80.
    """
    pattern = checked("a*a*a*a*(b)")
    assert picked(pattern, "a" * 100_000) == ""
    assert picked(checked(r"T=([-\d.]+) K"), "run 3, T=-12.5 K") == "-12.5"
    assert picked(checked(r"[+*?(]+(x)"), "a+*x") == "x"


def test_words_of_a_cell_that_may_take_long_are_cut(directory):
    add(directory, "long", GOOD)
    (directory / "long" / "raw.csv").write_text(TABLE + f"3,4,5,{'lane ' * 100_000}z\n")
    assert len(found()["long"].open()) == 3
