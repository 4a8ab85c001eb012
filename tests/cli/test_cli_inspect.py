"""``springpot inspect``: what a file holds."""

import shlex

KEYS = {
    "schema",
    "data",
    "points",
    "frequency",
    "storage",
    "loss",
    "standard_deviations",
    "conditions",
    "labels",
    "sweeps",
    "parts",
    "provenance",
}


def test_a_file(springpot, damper):
    answer = springpot("inspect", damper, "--json").json
    assert set(answer) == KEYS
    assert answer["schema"] == "springpot.inspection/1"
    assert (answer["data"], answer["points"]) == ("damper", 15)
    assert abs(answer["frequency"]["from"] - 0.5) < 1e-12
    assert answer["storage"]["unit"] == "kN/m"
    assert [(sweep["conditions"], sweep["points"]) for sweep in answer["sweeps"]] == [("all", 15)]
    shown = springpot("inspect", damper).out
    assert "15 points, 1 sweep\n" in shown
    assert "kN/m" in shown


def test_conditions_become_sweeps(springpot, write):
    rows = "\n".join(f"{f},1,2,{t}" for t in (10, 30) for f in (1, 2, 3))
    path = write(f"frequency [Hz],storage [Pa],loss [Pa],temperature [degC]\n{rows}\n")
    answer = springpot("inspect", path, "--json").json
    assert answer["conditions"] == {"temperature": {"from": 10.0, "to": 30.0, "unit": "degC"}}
    assert [sweep["points"] for sweep in answer["sweeps"]] == [3, 3]
    assert springpot("inspect", f"{path}@temperature=30", "--json").json["points"] == 3
    assert [sweep["conditions"] for sweep in answer["sweeps"]] == [
        "temperature 10",
        "temperature 30",
    ]
    assert "temperature [degC]" in springpot("inspect", path).out


def test_an_amplitude_sweep_is_one_line(springpot, write):
    """Amplitudes that differ between points and temperatures that wander a little are one run."""
    rows = "\n".join(f"1,{10 - i},2,{20 + i % 2 / 10},{0.01 * 2**i}" for i in range(9))
    path = write(
        f"frequency [Hz],storage [Pa],loss [Pa],temperature [degC],amplitude [%]\n{rows}\n"
    )
    [sweep] = springpot("inspect", path, "--json").json["sweeps"]
    assert sweep["points"] == 9
    assert (sweep["amplitude"]["from"], sweep["amplitude"]["to"]) == (0.01, 2.56)


def test_units_that_differ_in_case_only_are_doubted(springpot, write):
    path = write("frequency [Hz],storage [MPa],loss [mPa]\n1,2,3\n2,3,4\n4,4,5\n8,5,6\n")
    assert "storage in MPa but loss in mPa" in springpot("inspect", path).out
    answer = springpot("identify", path, "--model", "springpot", "--json")
    assert answer.json["model"] == "springpot"
    assert answer.err.startswith("note: data: storage in MPa but loss in mPa")
    assert "slip" not in springpot("inspect", write(path.read_text().replace("mPa", "kPa"))).out


def test_a_file_beside_the_name_is_suggested(springpot, damper):
    assert springpot("inspect", damper.with_suffix("")).is_one_line("did you mean", "damper.csv")
    assert springpot("signals", damper.with_name("dampr.csv")).is_one_line(
        "no such file", "damper.csv"
    )
    answer = springpot("signals", damper.with_name("other.txt"))
    assert answer.is_one_line("other.txt: there is no such file")
    assert "did you mean" not in answer.err


def test_the_part_to_go_on_with_is_chosen_before_what_is_said_of_columns(springpot, write):
    rows = "\n".join(f"{f},{100 + f},{10 + f},{200 + f},{20 + f}" for f in range(1, 8))
    file = write(f"f,run 1,,run 2,\nHz,G',G'',G',G''\n{rows}\n", "runs.csv")
    answer = springpot("inspect", f"{file}?storage=Pa,loss=Pa")
    assert answer.code == 0
    command = shlex.split(answer.out.splitlines()[-1])
    assert command == ["next:", "springpot", "compare", f"{file}#1?storage=Pa,loss=Pa"]
    assert springpot("inspect", command[3]).code == 0
