"""``springpot inspect``: what a file holds."""

KEYS = {
    "schema", "data", "points", "frequency", "storage", "loss", "standard_deviations", "conditions", "labels",
    "sweeps", "parts", "provenance",
}  # fmt: skip


def test_a_file(springpot, damper):
    answer = springpot("inspect", damper, "--json").json
    assert set(answer) == KEYS
    assert answer["schema"] == "springpot.inspection/1"
    assert (answer["data"], answer["points"]) == ("damper", 15)
    assert abs(answer["frequency"]["from"] - 0.5) < 1e-12
    assert answer["storage"]["unit"] == "kN/m"
    assert answer["sweeps"] == [{"conditions": "all", "points": 15}]
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
    assert "temperature 30" in springpot("inspect", path).out
