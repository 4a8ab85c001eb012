"""What a user is told to do next: unknown columns, repeats and drift."""

import csv
import json
import re
import shlex

import numpy as np
import pytest

import springpot
from springpot.cli.group import exit_code, run
from springpot.errors import DataError

pytestmark = pytest.mark.usefixtures("asked_once")

SWEEP = np.geomspace(0.5, 50.0, 8)
"""Frequencies in Hz at which each value of a column is measured."""
LONG = np.geomspace(0.5, 50.0, 32)
MASSES = {"inertia", "specimen-inertia"}
"""A mass of the rig and one of the specimen are one curve at low frequencies."""
LANES = ("Lane 1 (recovered, no ageing)", "Lane 2 (recovered, aged)", "plain")


def damper(frequency, k=400.0, c=60.0, alpha=0.5):
    """A fractional Maxwell element at frequencies in Hz."""
    flow = c * (2j * np.pi * frequency) ** alpha
    return k * flow / (k + flow)


def heavy(frequency):
    """A mass of 0.6 kg moves with the damper, which is told in kN/m."""
    return damper(frequency) - 6e-4 * (2.0 * np.pi * frequency) ** 2


def noisy(stiffness, level, seed=5):
    """Noise as a complex factor, each of its parts of the size `level`."""
    storage, loss = np.random.default_rng(seed).normal(size=(2, len(stiffness)))
    return stiffness * (1.0 + level * (storage + 1j * loss))


def table(frequency, stiffness, **columns):
    """A table as the user writes it; the keyword `current_in_A` is the column `current [A]`."""
    given = {
        "frequency [Hz]": frequency,
        "storage [kN/m]": stiffness.real,
        "loss [kN/m]": stiffness.imag,
    }
    for keyword, cells in columns.items():
        name, unit_follows, unit = keyword.partition("_in_")
        if unit_follows:
            name = f"{name} [{unit}]"
        given[name] = cells
    return given


def levels(values, gains, column, level=0.005, law=damper, rows="frequencies"):
    """The law with a gain of its own at each value of a column, in the order of measurement."""
    which, frequency = np.repeat(np.arange(len(values)), len(SWEEP)), np.tile(SWEEP, len(values))
    order = {
        "sweeps": np.arange(len(which)),
        "frequencies": np.lexsort((which, frequency)),
        "random": np.random.default_rng(1).permutation(len(which)),
    }[rows]
    stiffness = noisy(np.asarray(gains)[which] * law(frequency), level)
    return table(frequency[order], stiffness[order], **{column: [values[i] for i in which[order]]})


@pytest.fixture(scope="module")
def save(tmp_path_factory):
    """Write a table into the module's folder; the same name gives the same file."""
    folder = tmp_path_factory.mktemp("my data")

    def write(name, columns):
        path = folder / f"{name}.csv"
        with path.open("w", newline="") as file:
            rows = csv.writer(file)
            rows.writerow(columns)
            cells = [
                getattr(column, "tolist", lambda column=column: column)()
                for column in columns.values()
            ]
            rows.writerows(zip(*cells, strict=True))
        return str(path)

    return write


@pytest.fixture(scope="module")
def unexplained(save):
    """A sweep from high to low, and a gain that wanders along its rows.

    Two columns have nothing to do with it.
    """
    wander = 1.0 + 0.005 * np.sin(np.linspace(0.0, 4.0, len(LONG)))
    stiffness = noisy(wander * damper(LONG[::-1]), 0.0005)
    torque = np.abs(stiffness) * np.random.default_rng(2).uniform(0.9, 1.1, len(LONG))
    return save(
        "drift",
        table(LONG[::-1], stiffness, torque_in_Nm=torque, preload_in_N=np.full(len(LONG), 5.0)),
    )


@pytest.fixture(scope="module")
def heavy_file(save):
    """A mass moves with the damper; the labels are dealt out by chance."""
    labels = np.random.default_rng(0).choice(list("abc"), len(LONG))
    return save("heavy", table(LONG, noisy(heavy(LONG), 0.005), batch=labels))


@pytest.fixture
def tells(capsys):
    """Run one command line in this process and give its standard output; it must end well."""

    def call(*words):
        capsys.readouterr()
        code = exit_code(lambda: run(list(words)))
        said = capsys.readouterr()
        assert code == 0, said.err
        return said.out

    return call


def diagnosed(path, model=None):
    return springpot.diagnose(springpot.read(path), model)


def next_command(text):
    """The words of the command in the last line."""
    last = text.rstrip().splitlines()[-1]
    assert last.startswith("next: springpot "), text
    return shlex.split(last.removeprefix("next: "))[1:]


# A column that no effect knows.

COLUMNS = {
    "current": ("current_in_A", (0.5, 1.0, 2.0), (1.0, 1.3, 1.6), "frequencies"),
    "preload": ("preload_in_N", (10.0, 20.0, 50.0), (1.0, 1.04, 1.1), "sweeps"),
    "batch": ("batch", ("old", "new", "spare", "own"), (1.0, 1.2, 0.9, 1.4), "frequencies"),
}
"""Column, its values, the gain at each, and how the rows are sorted."""


@pytest.fixture(scope="module")
def apart(save):
    """Files in which one column sets the rows apart, by its name.

    The first has columns that cannot be it.
    """
    tables = {}
    for name, (column, values, gains, rows) in COLUMNS.items():
        tables[name] = levels(values, gains, column, rows=rows)
    rows = len(tables["current"]["frequency [Hz]"])
    chance = np.random.default_rng(4)
    tables["current"]["clamp [N]"] = np.full(rows, 5.0)
    tables["current"]["torque [Nm]"] = chance.uniform(1.0, 2.0, rows)
    tables["current"]["operator"] = chance.choice(["Ann", "Bo"], rows)
    return {name: save(name, columns) for name, columns in tables.items()}


@pytest.mark.soak_cases("batch", "current", "preload")
@pytest.mark.parametrize("name", COLUMNS)
def test_a_column_that_sets_the_rows_apart_is_named(apart, name):
    found = diagnosed(apart[name])
    assert found.verdict in {"unexplained", "inconclusive"}
    assert f"it goes with {name}" in found.says
    assert found.error.relative_rms > 3.0 * found.error.noise_floor
    column, _, value = found.one_test.partition("=")
    assert column == name
    assert value in [f"{cell}".removesuffix(".0") for cell in COLUMNS[name][1]]


@pytest.mark.soak
@pytest.mark.parametrize("name", COLUMNS)
def test_its_selector_opens_one_test_alone(apart, name):
    _, values, gains, _ = COLUMNS[name]
    one_test = diagnosed(apart[name]).one_test
    part = springpot.read(f"{apart[name]}@{one_test}")
    np.testing.assert_allclose(np.sort(part.omega), 2.0 * np.pi * SWEEP)
    at = [f"{name}={cell}".removesuffix(".0") for cell in values].index(one_test)
    exact = gains[at] * np.abs(damper(part.omega / (2.0 * np.pi)))
    np.testing.assert_allclose(np.abs(part.stiffness), exact, rtol=0.03)
    assert springpot.diagnose(part, "fractional-maxwell").verdict == "adequate"


@pytest.mark.soak_cases("batch", "current")
@pytest.mark.parametrize("name", ["current", "batch"])
def test_the_last_line_is_a_command_that_runs(apart, tells, name):
    words = next_command(tells("diagnose", apart[name]))
    assert words == ["diagnose", f"{apart[name]}@{diagnosed(apart[name]).one_test}"]
    title = tells(*words).splitlines()[0]
    assert title.endswith((": adequate", ": inconclusive"))


@pytest.mark.soak
def test_a_column_behind_the_misfit_is_in_json_and_opens_again(apart, tells, tmp_path):
    kept = tmp_path / "diagnosis.json"
    kept.write_text(tells("diagnose", apart["current"], "--json"))
    assert "current=0.5" in kept.read_text()
    assert springpot.load(kept).one_test == "current=0.5"


def shuffled(save, gains):
    """Four currents in no order: a table may be sorted by frequency, by column, or not at all."""
    return save(
        f"shuffled {gains[1]}", levels((0.0, 0.5, 1.0, 1.5), gains, "current_in_A", rows="random")
    )


@pytest.mark.soak_cases("gains0", "gains1")
@pytest.mark.parametrize("gains", [(1.0, 1.2, 0.9, 1.5), (1.0, 1.03, 0.98, 1.05)])
def test_the_order_of_the_rows_does_not_hide_the_column(save, gains):
    found = diagnosed(shuffled(save, gains))
    assert found.verdict != "adequate"
    assert "current" in found.says
    assert found.one_test == "current=0"


@pytest.mark.soak
def test_the_noise_is_not_the_difference_of_the_values(save):
    """Four gains up to 50 % apart, noise of 0.7 % of |K|."""
    assert diagnosed(shuffled(save, (1.0, 1.2, 0.9, 1.5))).error.noise_floor < 0.02


@pytest.mark.soak
@pytest.mark.parametrize("gain", [0.08, 0.0])
def test_rows_of_two_calibrations_that_take_turns_are_no_noise(gain):
    """Scatter to all that does not know which geometry a row was measured on."""
    rng = np.random.default_rng(3)
    s = (2j * np.pi * np.geomspace(0.1, 100.0, 60)) ** 0.5
    plates = 25.0 - 17.0 * (rng.permutation(60) % 2)
    storage, loss = rng.normal(size=(2, 60))
    exact = 400.0 * 60.0 * s / (400.0 + 60.0 * s) * np.where(plates < 20.0, 1.0 + gain, 1.0)
    data = springpot.Measurement(
        2.0 * np.pi * np.geomspace(0.1, 100.0, 60),
        exact * (1.0 + 0.005 * (storage + 1j * loss)),
        conditions={"plates": plates},
    )
    found = springpot.diagnose(data, "fractional-maxwell")
    if gain == 0.0:
        assert found.verdict == "adequate"
        return
    assert found.verdict == "unexplained"
    assert "plates" in found.says
    assert not found.split
    (step,) = found.steps
    assert step.split == "plates"
    assert step.error_after == pytest.approx(0.007, rel=0.2)


@pytest.mark.soak
def test_gains_that_rise_and_fall_from_sweep_to_sweep_are_no_fault():
    """Waves in the specimen are tried beside any material; their slopes are too small to square."""
    frequency, gains = np.tile(np.geomspace(0.5, 50.0, 10), 4), np.repeat([1.0, 1.2, 0.9, 1.5], 10)
    s = (2j * np.pi * frequency) ** 0.5
    storage, loss = np.random.default_rng(5).normal(size=(2, 40))
    stiffness = (
        gains * (400.0 * 60.0 * s / (400.0 + 60.0 * s)) * (1.0 + 0.005 * (storage + 1j * loss))
    )
    batch = np.repeat(["a", "b", "c", "d"], 10)
    data = springpot.Measurement(2.0 * np.pi * frequency, stiffness, labels={"batch": batch})
    assert springpot.diagnose(data).one_test == "batch=a"


@pytest.mark.parametrize(
    "words",
    [
        ("new", "newer", "newest"),
        ("1,5 bar", "1,5 bar again", "2 bar"),
        ("Al's", "Bob's", "Cy's"),
        ("#2, 50%", "#3, 50%", "what?"),
        ("a=1", "a=2", "a=3"),
        ("PG 64-22 @ 58", "PG 64-28 @ 58", "plain"),
        ("A", "a", "B"),
    ],
)
def test_whatever_the_words_the_selector_of_the_note_opens_those_rows(save, tells, words):
    path = save("words", levels(words, (1.0, 1.2, 0.9), "batch"))
    said = " ".join(tells("inspect", path).split())
    [selector] = re.findall(r"choose one by '@(.+?)'(?: |$)", said)
    part = springpot.read(f"{path}@{selector}")
    assert len(part.omega) == len(SWEEP)
    assert len(set(part.labels["batch"].tolist())) == 1


@pytest.mark.soak
def test_numbers_of_batches_are_no_sizes(save):
    """1001 and 1002 are as different as 1 and 2; what opens all rows again is no next step."""
    path = save("numbers", levels((1001, 1002, 1003), (1.0, 1.2, 0.9), "batch"))
    one_test = diagnosed(path).one_test
    assert one_test == "batch=1001"
    assert len(springpot.read(f"{path}@{one_test}").omega) == len(SWEEP)


@pytest.mark.soak
def test_a_column_of_which_the_misfit_is_independent_is_not_named(save):
    """A mass at every current alike; and a second file from which nothing is missing."""
    missing = diagnosed(
        save("every", levels((1.0, 2.0, 3.0), (1.0, 1.0, 1.0), "current_in_A", law=heavy)),
        "fractional-maxwell",
    )
    assert missing.leading[0] in MASSES
    nothing = diagnosed(save("nothing", levels((1.0, 2.0, 3.0), (1.0, 1.0, 1.0), "current_in_A")))
    assert nothing.verdict == "adequate"
    for found in (missing, nothing):
        assert "current" not in found.says
        assert not found.one_test


@pytest.mark.soak
def test_labels_by_chance_do_not_hide_a_mass(heavy_file):
    found = diagnosed(heavy_file)
    assert found.verdict == "effect-missing"
    assert found.leading[0] in MASSES
    assert "batch" not in found.says
    assert not found.one_test


@pytest.mark.soak
def test_columns_of_every_row_and_of_all_rows_are_not_named(unexplained):
    """A measured torque goes with everything, a preload that was never changed with nothing."""
    found = diagnosed(unexplained)
    assert found.verdict == "unexplained"
    assert not found.one_test
    for name in ("torque", "preload", "goes with"):
        assert name not in found.says + " ".join(found.notes)


@pytest.mark.soak
def test_a_column_that_goes_one_to_one_with_temperature_is_not_put_before_it(save):
    """Each temperature was another run: an effect that knows the temperature explains the rows."""
    celsius, frequency = np.repeat([0.0, 20.0, 40.0], len(SWEEP)), np.tile(SWEEP, 3)
    shift = np.exp(60.0 / 8.314e-3 * (1.0 / (celsius + 273.15) - 1.0 / 293.15))
    stiffness = noisy(damper(frequency * shift), 0.01)
    run = [f"run {cell:g}" for cell in celsius]
    found = diagnosed(
        save("oven", table(frequency, stiffness, temperature_in_degC=celsius, run=run))
    )
    assert found.verdict == "effect-missing"
    assert found.leading[0] in {"arrhenius-shift", "wlf-shift"}
    assert "run" not in found.says
    assert not found.one_test


def test_rows_at_other_preloads_are_not_said_to_stand_under_the_same_conditions(apart, tells):
    """Each frequency stands once at each preload: there is nothing to number."""
    said = tells("inspect", apart["preload"])
    assert "same conditions" not in " ".join(said.split())
    assert "3 sweeps" in said.splitlines()[0]


# Repeats.

MATERIALS = {"soft": (200.0, 60.0, 0.5), "hard": (900.0, 30.0, 0.7), "thick": (400.0, 150.0, 0.3)}
SCATTER = 0.01
"""Noise of each part of K over |K|, so that a point is off by the root of two times as much."""


def repeated(column, laws):
    """Each law measured three times, one frequency after the other; the column holds its name."""
    frequency = np.tile(SWEEP, 3 * len(laws))
    repeat, word = (
        np.tile(np.repeat([1, 2, 3], len(SWEEP)), len(laws)),
        np.repeat(list(laws), 3 * len(SWEEP)),
    )
    exact = np.concatenate([np.tile(damper(SWEEP, *law), 3) for law in laws.values()])
    stiffness = noisy(exact, SCATTER)
    order = np.lexsort((word, repeat, frequency))
    return table(frequency[order], stiffness[order], repeat=repeat[order], **{column: word[order]})


@pytest.mark.soak
def test_different_materials_are_no_noise_of_repeats(save):
    path = save("binder", repeated("binder", MATERIALS))
    found = diagnosed(path)
    assert found.error.noise_source == "repeats"
    assert found.error.noise_floor == pytest.approx(np.sqrt(2.0) * SCATTER, rel=0.3)
    assert found.verdict != "adequate"
    assert found.error.relative_rms > 0.2
    assert "it goes with binder" in found.says
    one = springpot.diagnose(springpot.read(f"{path}@{found.one_test}"), "fractional-maxwell")
    assert one.verdict == "adequate"
    assert one.error.noise_source == "repeats"


@pytest.mark.soak
@pytest.mark.parametrize("model", [None, "fractional-maxwell"])
def test_specimens_that_are_the_repeats_tell_the_noise(save, model):
    columns = repeated("lane", {"one": (400.0, 60.0, 0.5)})
    del columns["lane"]
    columns["specimen"] = [f"S{number}" for number in columns["repeat"]]
    found = diagnosed(save("specimen", columns), model)
    assert found.error.noise_source == "repeats"
    assert found.error.noise_floor == pytest.approx(np.sqrt(2.0) * SCATTER, rel=0.35)
    assert found.verdict == "adequate"
    assert not found.one_test


@pytest.mark.soak
def test_three_materials_that_were_numbered_as_repeats_are_not_adequate(save):
    """An error of 90 % of |K| is no noise of any of them; it is 1.8 times the so-called floor."""
    stiffness = noisy(np.concatenate([damper(SWEEP, k) for k in (400.0, 900.0, 100.0)]), SCATTER)
    numbers, words = (
        np.repeat([1, 2, 3], len(SWEEP)),
        np.repeat(["soft", "hard", "thick"], len(SWEEP)),
    )
    columns = table(np.tile(SWEEP, 3), stiffness, repeat=numbers, material=words)
    found = diagnosed(save("numbered", columns))
    assert found.verdict != "adequate"


@pytest.mark.soak
def test_currents_that_were_numbered_as_repeats_are_not_adequate(save):
    """A point at another current was not measured again.

    Here they are 30 and 60 % apart, in noise of 1.4 %.
    """
    columns = levels((0.0, 0.5, 1.0), (1.0, 1.3, 1.6), "current_in_A", level=SCATTER)
    columns["repeat"] = [1 + int(2.0 * current) for current in columns["current [A]"]]
    found = diagnosed(save("numbered currents", columns))
    assert found.verdict != "adequate"


# Words with commas.


@pytest.fixture(scope="module")
def lanes(save):
    """Three binders at three temperatures; a decade of time for ten degrees."""
    parts = [(lane, celsius) for lane in LANES for celsius in (46.0, 52.0, 58.0)]
    exact = [
        damper(SWEEP * 10.0 ** (-(celsius - 52.0) / 10.0), [400.0, 900.0, 100.0][LANES.index(lane)])
        for lane, celsius in parts
    ]
    rows = np.repeat(np.arange(len(parts)), len(SWEEP))
    return save(
        "lanes",
        table(
            np.tile(SWEEP, len(parts)),
            noisy(np.concatenate(exact), 0.01),
            temperature_in_degC=[parts[row][1] for row in rows],
            binder=[parts[row][0] for row in rows],
        ),
    )


@pytest.mark.parametrize(
    ("selector", "points", "celsius"),
    [
        ("binder=Lane 1 (recovered, no ageing)", 24, {46.0, 52.0, 58.0}),
        ("binder=Lane 1 (recovered, no ageing),temperature=58", 8, {58.0}),
        ("temperature=58,binder=Lane 1 (recovered, no ageing)", 8, {58.0}),
        ("binder=Lane 1", 24, {46.0, 52.0, 58.0}),
    ],
)
def test_words_with_commas_choose_rows(lanes, selector, points, celsius):
    part = springpot.read(f"{lanes}@{selector}")
    assert len(part.omega) == points
    assert set(part.labels["binder"].tolist()) == {LANES[0]}
    assert set(part.conditions["temperature"].tolist()) == celsius


@pytest.mark.parametrize(
    "selector",
    [
        "binder=Lane",
        "binder=Lane 1 (recovered, aged)",
        "binder=Lane 1 (recovered, no ageing),temperature=99",
    ],
)
def test_words_that_choose_no_one_are_refused_with_what_there_is(lanes, selector):
    with pytest.raises(
        DataError, match=r"there are: (46, 52, 58|Lane 1 \(recovered, no ageing\), Lane 2)"
    ):
        springpot.read(f"{lanes}@{selector}")


def test_the_note_gives_a_selector_that_works(lanes, tells):
    said = " ".join(tells("inspect", lanes).split())
    [selector] = re.findall(r"choose one by '@(.+?)'(?: |$)", said)
    assert selector == f"binder={LANES[0]}"
    assert len(springpot.read(f"{lanes}@{selector}").omega) == 24


@pytest.mark.soak
def test_a_selector_with_commas_and_a_model_pass_through_a_shell(lanes, tells):
    words = next_command(
        tells("diagnose", f"{lanes}@temperature=58", "--model", "fractional-maxwell")
    )
    assert words[0] == "diagnose"
    assert words[2:] == ["--model", "fractional-maxwell"]
    part = springpot.read(words[1])
    assert set(part.labels["binder"].tolist()) == {LANES[0]}
    assert set(part.conditions["temperature"].tolist()) == {58.0}
    assert tells(*words).splitlines()[0].endswith(": adequate")


# Next steps.


@pytest.mark.soak
def test_what_is_unexplained_is_measured_again_in_the_opposite_order(unexplained):
    found = diagnosed(unexplained)
    assert found.verdict == "unexplained"
    advice = found.next_experiment
    assert "opposite order" in advice.says
    assert tuple(advice.separates) == ()
    assert advice.expected_separation_sigma is None
    np.testing.assert_allclose(advice.action["omega"], 2.0 * np.pi * LONG)


@pytest.mark.soak
def test_json_of_it_has_null_and_opens_again(unexplained, tells, tmp_path):
    text = tells("diagnose", unexplained, "--json")
    advice = json.loads(text)["next_experiment"]
    assert advice["expected_separation_sigma"] is None
    assert advice["separates"] == []
    kept = tmp_path / "diagnosis.json"
    kept.write_text(text)
    again = springpot.load(kept)
    assert again.next_experiment == diagnosed(unexplained).next_experiment
    assert again.to_dict() == diagnosed(unexplained).to_dict()


@pytest.mark.soak
def test_where_an_effect_is_missing_the_next_line_accepts_it(heavy_file, tells):
    found = diagnosed(heavy_file)
    words = next_command(tells("diagnose", heavy_file))
    assert words == ["discover", heavy_file, "--accept", found.leading[0]]
    assert found.leading[0] in MASSES
    assert found.leading[0] in found.says
    assert found.leading[0] in tells(*words)


@pytest.mark.soak
def test_where_nothing_is_missing_and_no_model_was_named_models_are_compared(save, tells):
    path = save("sound", table(LONG, noisy(damper(LONG), 0.005)))
    assert next_command(tells("diagnose", path)) == ["compare", path]


@pytest.mark.soak_cases("a few hundred sigma", "more than a thousand")
@pytest.mark.parametrize(
    ("level", "more"),
    [(3e-4, False), (8e-5, True)],
    ids=["a few hundred sigma", "more than a thousand"],
)
def test_no_measurement_is_promised_to_tell_more_than_a_thousand_sigma(level, more):
    """A delay of 0.3 ms and a resonance that acts like one: the less noise the further apart."""
    frequency = np.geomspace(0.5, 50.0, 16)
    late = noisy(damper(frequency) * np.exp(-2j * np.pi * frequency * 3e-4), level, seed=0)
    data = springpot.Measurement(2.0 * np.pi * frequency, late, units=springpot.Units("kN/m", "mm"))
    advice = springpot.diagnose(data, "fractional-maxwell").next_experiment
    assert not re.search(r"\d[eE]|\^|\d{5}", advice.says)
    assert ("by more than 1000 sigma" in advice.says) == more
    assert (advice.expected_separation_sigma > 1000.0) == more
