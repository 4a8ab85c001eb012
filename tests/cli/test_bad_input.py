"""Wrong input: ``springpot identify`` says so in one line and leaves with exit code 2."""

import pytest

GOOD = "frequency [Hz],storage [kN/m],loss [kN/m]\n1,100,20\n2,120,25\n4,150,30\n8,170,36\n"
HEAD = "frequency [Hz],storage [kN/m],loss [kN/m]\n"

FILES = {
    "missing column": ("frequency [Hz],storage [kN/m]\n1,2\n2,3\n", ["loss"]),
    "storage without unit": (GOOD.replace("storage [kN/m]", "storage"), ["storage", "unit"]),
    "unknown unit": (GOOD.replace("storage [kN/m]", "storage [kM/n]"), ["kM/n"]),
    "two units": (GOOD.replace("loss [kN/m]", "loss [Pa]"), ["loss", "Pa"]),
    "negative frequency": (GOOD.replace("\n2,", "\n-2,"), ["frequency", "positive"]),
    "zero frequency": (GOOD.replace("\n2,", "\n0,"), ["frequency", "positive"]),
    "duplicate frequency": (GOOD.replace("\n2,", "\n1,"), ["frequency", "already", "repeat"]),
    "nan": (GOOD.replace("120", "nan"), ["storage", "line 3"]),
    "infinite": (GOOD.replace("120", "inf"), ["storage", "line 3"]),
    "text": (GOOD.replace("120", "about 120"), ["about 120", "line 3"]),
    "short row": (GOOD.replace("2,120,25", "2,120"), ["line 3"]),
    "empty": ("", ["empty"]),
    "only a header": (HEAD, ["no"]),
    "one point": (HEAD + "1,100,20\n", ["one point"]),
    "another encoding": (GOOD.encode() + b"16,\xff\xfe\x80,7\n", []),
    "binary": (bytes(range(256)) * 40, []),
    "no table": ("Dear colleague,\n\nhere are the results.\n", []),
    "negative deviation": (
        (
            "frequency [Hz],storage [Pa],loss [Pa],storage_sd [Pa],"
            "loss_sd [Pa]\n1,2,3,-1,1\n2,3,4,1,1\n"
        ),
        ["storage_sd", "positive"],
    ),
}


@pytest.mark.parametrize("case", FILES)
def test_bad_file(springpot, write, case):
    content, words = FILES[case]
    path = write(content, "bad-data.csv")
    answer = springpot("identify", path, "--model", "fractional-kelvin")
    assert answer.is_one_line("bad-data", *words)


@pytest.mark.parametrize("model", ["spring", "maxwell", "fractional-zener"])
def test_one_point_whatever_the_model(springpot, write, model):
    assert springpot("identify", write(HEAD + "1,100,20\n"), "--model", model).is_one_line(
        "one point"
    )


def test_the_good_file_is_good(springpot, write):
    assert springpot("identify", write(GOOD), "--model", "fractional-kelvin").code == 0


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ("/nowhere/of-ten-gigabytes.csv", ["of-ten-gigabytes.csv"]),
        ("no-such-set", ["no-such-set", "list datasets"]),
        ("", ["neither a file nor"]),
        (".", []),
        ("a" * 5000, []),
        ("bad\0name.csv", []),
    ],
)
def test_nothing_there(springpot, data, words):
    assert springpot("identify", data, "--model", "maxwell").is_one_line(*words)


def test_a_folder(springpot, tmp_path):
    assert springpot("identify", tmp_path, "--model", "maxwell").is_one_line("folder")


def test_no_such_condition(springpot, write):
    assert springpot("identify", f"{write(GOOD)}@temperature=20", "--model", "maxwell").is_one_line(
        "temperature"
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], ["missing option", "--model", "identify --help", "springpot compare DATA"]),
        (
            ["--model", "fractional-maxwel"],
            ["unknown model 'fractional-maxwel'", "fractional-maxwell"],
        ),
        (["--model", "maxwell + inertya"], ["unknown effect 'inertya'", "inertia"]),
        (["--model", "maxwell +"], ["empty part"]),
        (["--model", ""], ["empty part"]),
        (["--model", "prony-N"], ["prony-N", "number"]),
        (["--model", "prony-0"], ["prony-0"]),
        (["--model", "maxwell + friction"], ["amplitude"]),
        (["--model", "prony-20"], ["parameters", "points"]),
        (["--model", "maxwell", "--optimiser", "cma"], ["unknown optimiser 'cma'"]),
        (["--model", "maxwell", "--objective", "papr"], ["unknown objective 'papr'", "paper"]),
        (["--model", "maxwell", "--budget", "0"], ["--budget"]),
        (["--model", "maxwell", "--budget", "-1"], ["--budget"]),
        (["--model", "maxwell", "--budget", "many"], ["--budget", "many"]),
        (["--model", "maxwell", "--restarts", "0"], ["--restarts"]),
        (["--model", "maxwell", "--seed", "-3"], ["--seed"]),
        (["--model", "maxwell", "--intervals", "guess"], ["--intervals", "profile"]),
        (["--model", "maxwell", "--figure", "a.bmp"], ["a.bmp", ".png"]),
        (["--model", "maxwell", "--figure", "no-folder/a.png"], ["no-folder"]),
        (["--model", "maxwell", "--modle", "x"], ["--modle"]),
    ],
)
def test_bad_option(springpot, write, arguments, words):
    assert springpot("identify", write(GOOD), *arguments).is_one_line(*words)


def test_errors_leave_stdout_empty_with_json_too(springpot, write):
    assert springpot("identify", write(GOOD), "--model", "nonsense", "--json").is_one_line(
        "nonsense"
    )
