"""``--geometry``: the same data as a damper or as its material."""

import pytest

PADS = "shear-pads area=200cm^2 gap=10mm"


def test_a_damper_as_its_material(springpot, damper):
    device = springpot("identify", damper, "--model", "fractional-maxwell", "--json").json
    material = springpot(
        "identify", damper, "--model", "fractional-maxwell", "--geometry", PADS, "--json"
    ).json
    assert material["parameters"]["k"]["unit"] == "Pa"
    assert (
        abs(material["parameters"]["k"]["value"] / device["parameters"]["k"]["value"] / 500.0 - 1)
        < 1e-6
    )


@pytest.mark.soak
def test_every_command_that_opens_data_takes_it(springpot, damper):
    shown = springpot("inspect", damper, "--geometry", PADS)
    assert "Pa" in shown.out
    assert "geometry: shear-pads area=0.02 m^2 gap=0.01 m" in shown.out
    for command in ("diagnose", "compare"):
        answer = springpot(
            command, damper, "--model", "fractional-maxwell", "--geometry", PADS, "--json"
        )
        assert answer.code == 0, answer.err


def test_a_wrong_one_is_one_line(springpot, damper):
    assert springpot("inspect", damper, "--geometry", "pads").is_one_line("geometry 'pads'")
    answer = springpot("inspect", damper, "--geometry", "parallel-plates diameter=4cm gap=1mm")
    assert answer.is_one_line("torque and angle", "kN/m")
