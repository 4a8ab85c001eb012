"""A hint says more of a column, and never changes which one is meant."""

import os
from pathlib import Path

import numpy as np
import pytest

from springpot.errors import DataError
from springpot.registry import open_in_time, open_measurement, signals_to_measurement

UNSEEN = (
    Path(os.environ.get("SPRINGPOT_DATA") or Path(__file__).parents[4] / "shared" / "data").parent
    / "unseen"
)
CLOCK = np.linspace(0.0, 4.0, 801)
MOVED = np.sin(2.0 * np.pi * CLOCK)
PULLED = -3.0 * np.sin(2.0 * np.pi * CLOCK + 0.4)
VOLTS = 0.01 * PULLED
SWEEP = np.geomspace(1.0, 100.0, 8)


def rig(folder, titles, *columns):
    path = folder / "rig.csv"
    rows = [",".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([titles, *rows]) + "\n", encoding="utf-8")
    return path


def forces(path, hint):
    """Largest force of the record, and storage of step one of the paper, with this hint."""
    [test] = open_in_time(f"{path}?{hint}")
    return float(test.response.max()), signals_to_measurement([f"{path}?{hint}"]).storage[0]


@pytest.mark.suite_cases(
    "Force (V),Force (N),Displacement (mm)-force",
    "Load (V),Force (N),Displacement (mm)-Force",
    "Force/V,F [N],x [mm]-F",
)
@pytest.mark.parametrize("key", ["force", "Force", "load", "F"])
@pytest.mark.parametrize(
    "titles",
    [
        "Force (V),Force (N),Displacement (mm)",
        "Load (V),Force (N),Displacement (mm)",
        "Force/V,F [N],x [mm]",
    ],
)
def test_a_hint_of_a_force_means_the_column_that_is_taken_without_it(tmp_path, titles, key):
    path = rig(tmp_path, f"time [s],{titles}", CLOCK, VOLTS, PULLED, MOVED)
    if key.lower() == "load" and "Load" in titles:
        pytest.skip("names the other column")
    [plain] = open_in_time(path)
    stiffness = signals_to_measurement([path]).storage[0]
    largest, turned = forces(path, f"{key}=-N")
    assert largest == pytest.approx(-plain.response.min())
    assert turned == pytest.approx(-stiffness)


@pytest.mark.soak
def test_a_hint_of_a_displacement_means_the_column_that_is_taken_without_it(tmp_path):
    titles = "time [s],Displacement (V),Displacement (mm),Force (N)"
    path = rig(tmp_path, titles, CLOCK, 0.1 * MOVED, MOVED, PULLED)
    [plain], [turned] = open_in_time(path), open_in_time(f"{path}?displacement=-mm")
    assert turned.loading.value == pytest.approx(-plain.loading.value)
    assert signals_to_measurement([f"{path}?displacement=-mm"]).storage[0] == pytest.approx(
        -signals_to_measurement([path]).storage[0]
    )


@pytest.mark.parametrize(
    ("hint", "factor"), [("3=-N", -1.0), ("Force (N)=-N", -1.0), ("3=force[-N]", -1.0)]
)
def test_a_number_or_title_names_its_own_column(tmp_path, hint, factor):
    path = rig(tmp_path, "time [s],F1 [N],Force (N),Displacement (mm)", CLOCK, VOLTS, PULLED, MOVED)
    largest, _ = forces(path, hint)
    assert largest == pytest.approx((factor * PULLED).max(), rel=1e-6)


def test_an_ambiguous_hint_asks_in_one_line(tmp_path):
    path = rig(tmp_path, "time [s],Force,Load,Displacement (mm)", CLOCK, VOLTS, PULLED, MOVED)
    with pytest.raises(DataError) as asked:
        open_in_time(f"{path}?effort=N")
    assert "column 2, 'Force' or 3, 'Load'" in str(asked.value)
    assert "write 2=N or another number in its place" in str(asked.value)
    assert "\n" not in str(asked.value)
    # What is asked for leads on when it is typed as it stands.
    [test] = open_in_time(f"{path}?3=N")
    assert test.response.max() == pytest.approx(PULLED.max(), rel=1e-6)


@pytest.mark.parametrize("role", ["storage", "loss"])
def test_a_hint_of_a_modulus_means_the_calibrated_column(tmp_path, role):
    storage, loss = 100.0 + SWEEP, 20.0 * SWEEP**0.3
    titles = (
        "frequency [Hz],Storage modulus (V),Storage modulus (Pa),Loss modulus (V),Loss modulus (Pa)"
    )
    path = rig(tmp_path, titles, SWEEP, 1e-3 * storage, storage, 1e-3 * loss, loss)
    plain, hinted = open_measurement(path), open_measurement(f"{path}?{role}=Pa")
    np.testing.assert_allclose(plain.storage, storage, rtol=1e-8)
    assert (hinted.stiffness == plain.stiffness).all()


def test_the_unit_that_the_file_says_otherwise_is_noted_of_a_test_in_time(tmp_path):
    path = rig(tmp_path, "time [s],Force (N),Displacement (mm)", CLOCK, PULLED, MOVED)
    [test] = open_in_time(f"{path}?force=-kN")
    assert test.provenance["note columns"] == "'Force (N)' is in kN as you said; the file says N"


def test_a_turned_sign_of_a_real_record_keeps_its_size():
    [path] = UNSEEN.glob("extract_t1_1*") if UNSEEN.is_dir() else [None]
    if path is None:
        pytest.skip("no shared records")
    [plain], [turned] = open_in_time(path), open_in_time(f"{path}?force=-N")
    assert turned.response == pytest.approx(-plain.response)


@pytest.mark.parametrize(
    "hint", ["force=-Force (N)[N]", "Force (N)=-force[N]", "force=Force (V)[N]"]
)
def test_a_sign_or_a_column_in_the_place_of_a_meaning_is_refused(tmp_path, hint):
    """It would be dropped without a word: the force not turned, or the other column taken."""
    titles = "Time (s),Displacement (mm),Force (V),Force (N)"
    path = rig(tmp_path, titles, CLOCK, MOVED, VOLTS, PULLED)
    for opened in (open_in_time, lambda name: signals_to_measurement([name])):
        with pytest.raises(DataError, match="a meaning is one word with its unit"):
            opened(f"{path}?{hint}")


FIRST, SECOND = PULLED.max(), 2.0 * PULLED.max()


@pytest.mark.parametrize(
    ("hint", "largest"),
    [
        ("4=ignore", FIRST),
        ("3=ignore", SECOND),
        ("force=ignore", SECOND),
        ("Force 2=ignore", FIRST),
        ("Force 2=force[N]", SECOND),
    ],
)
def test_a_column_that_is_to_be_ignored_is_as_though_it_were_not_there(tmp_path, hint, largest):
    """And one that is called by its number is no other."""
    titles = "time [s],Displacement (mm),Force (N),Force 2 (N)"
    path = rig(tmp_path, titles, CLOCK, MOVED, PULLED, 2.0 * PULLED)
    plain = signals_to_measurement([path]).magnitude[0] / PULLED.max()
    assert signals_to_measurement([f"{path}?{hint}"]).magnitude[0] == pytest.approx(
        plain * largest, rel=1e-6
    )
    [test] = open_in_time(f"{path}?{hint}")
    assert test.response.max() == pytest.approx(largest, rel=1e-6)


def test_of_signals_without_their_last_sensor_its_column_is_asked_for(tmp_path):
    path = rig(tmp_path, "time [s],Displacement (mm),Force (N)", CLOCK, MOVED, PULLED)
    with pytest.raises(DataError, match="no column of force"):
        signals_to_measurement([f"{path}?3=ignore"])


def test_of_numbers_without_names_that_begin_at_0_the_hint_says_a_time_first(tmp_path):
    """No frequency is 0, and the hint opens the file as it is printed."""
    path = tmp_path / "record.txt"
    np.savetxt(path, np.column_stack([CLOCK, MOVED, PULLED]))
    with pytest.raises(DataError, match="the first begins at 0, as a time does") as asked:
        open_measurement(path)
    hint = str(asked.value).split("record.txt?")[1].split("'")[0]
    assert hint == "1=time[s],2=displacement[mm],3=force[N]"
    [test] = open_in_time(f"{path}?{hint}")
    np.testing.assert_allclose(test.response, PULLED)


def test_names_that_a_remark_parts_from_the_numbers_are_offered(tmp_path):
    path = tmp_path / "clot.txt"
    rows = "\n".join(f"\t\t{i}\t{5 * i}\t{0.25 + i**0.5}" for i in range(1, 8))
    path.write_text(f"NAME\tCHANNEL\tSeq\tTime(sec)\tValue\nSample C\t3\n{rows}\n")
    with pytest.raises(
        DataError, match=r"columns:? NAME, CHANNEL, Seq, Time\(sec\), Value"
    ) as asked:
        open_measurement(path)
    assert "without names" not in str(asked.value)
    [test] = open_in_time(f"{path}?Value=compliance[1/Pa]")
    np.testing.assert_allclose(test.time, 5.0 * np.arange(1, 8))


def test_of_two_moduli_beside_a_loss_angle_the_second_may_be_the_loss(tmp_path):
    path = rig(
        tmp_path, "f [Hz],E1 [MPa],E2 [MPa],tan d", SWEEP, 3.0 + SWEEP, 0.3 * SWEEP, 0.1 * SWEEP
    )
    with pytest.raises(DataError, match=r"if E1 .* is the whole one") as asked:
        open_measurement(path)
    hint = str(asked.value).rsplit("?", 1)[1].removesuffix("'")
    assert hint == "2=storage[MPa],3=loss[MPa]"
    found = open_measurement(f"{path}?{hint}")
    np.testing.assert_allclose(found.loss, 0.3 * SWEEP, rtol=1e-6)


@pytest.mark.parametrize("place", [2, 3])
@pytest.mark.parametrize("was_set", [0.1 + 0.1 * np.arange(8), [*SWEEP[:0:-1], 1.2]])
def test_of_numbers_without_names_what_goes_in_even_steps_leads_the_hint(tmp_path, place, was_set):
    """Frequencies behind the moduli, up or down; the last step may be cut at an end."""
    columns = [3.0 + np.sqrt(SWEEP), 1.0 + 0.3 * np.sin(SWEEP)]
    columns.insert(place - 1, np.array(was_set))
    path = tmp_path / "sweep.txt"
    np.savetxt(path, np.column_stack(columns))
    with pytest.raises(DataError, match=f"number {place} goes in even steps") as asked:
        open_measurement(path)
    hint = str(asked.value).split("sweep.txt?")[1].split("'")[0]
    found = open_measurement(f"{path}?{hint}")
    np.testing.assert_allclose(np.sort(found.omega), np.sort(was_set))


def test_a_column_without_a_title_may_be_the_frequency(tmp_path):
    path = rig(tmp_path, ",G' [Pa],G'' [Pa]", SWEEP, 3.0 + SWEEP, 0.3 * SWEEP)
    with pytest.raises(DataError, match=r"if column 1 \(without a title\) is it, in Hz") as asked:
        open_measurement(path)
    hint = str(asked.value).split("rig.csv?")[1].split("'")[0]
    np.testing.assert_allclose(open_measurement(f"{path}?{hint}").frequency, SWEEP)


def test_a_word_before_the_names_in_a_remark_is_none_of_them(tmp_path):
    """As AFMs export them, the units in a remark with such a word as well."""
    path = tmp_path / "curve.txt"
    head = "# speed: 1.0\n# columns: time height force\n# units: s um nN\n#\n"
    rows = "\n".join(f"{t} {x} {f}" for t, x, f in zip(CLOCK, MOVED, PULLED, strict=True))
    path.write_text(head + rows + "\n")
    [test] = open_in_time(f"{path}?height=displacement[um]")
    np.testing.assert_allclose(test.response, PULLED)
    assert test.units.stiffness == "nN/um"


def test_a_shear_rate_with_its_unit_in_the_name_is_steady_flow(tmp_path):
    path = rig(tmp_path, "sample_id,shear_rate_1/s,stress_Pa", SWEEP, SWEEP, np.sqrt(SWEEP))
    with pytest.raises(DataError, match="steady flow, no dynamic test"):
        open_measurement(path)


def test_a_list_of_columns_that_is_cut_says_how_many_are_left_out(tmp_path):
    titles = ["time [s]", "Displacement (mm)", *(f"sensor {i}" for i in range(12))]
    path = rig(tmp_path, ",".join(titles), CLOCK, MOVED, *[PULLED] * 12)
    with pytest.raises(DataError, match=r"sensor 9 and 2 more\)$"):
        open_in_time(path)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (",G',G''\nrad/s,Pa,Pa\n1,2,3\n2,3,4\n3,4,5\n", "if column 1 (without a title) is it"),
        (
            ",Force,Time\nmm,N,s\n0,2,0\n0.1,3,1\n0.3,4,2\n0.4,6,3\n",
            "but column 1 (without a title), which moves one way",
        ),
    ],
)
def test_a_column_with_a_unit_and_no_title_is_called_by_its_number(tmp_path, text, told):
    path = tmp_path / "rig.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(DataError) as asked:
        open_in_time(path) or open_measurement(path)
    assert told in str(asked.value)
    hint = str(asked.value).split("rig.csv?")[1].split("'")[0]
    assert open_in_time(f"{path}?{hint}") or open_measurement(f"{path}?{hint}")


@pytest.mark.parametrize(
    ("titles", "told"),
    [
        ("omega [rad/s],,,", "column 2 (without a title), column 3 (without a title);"),
        ("time (s),,force (N),", "(columns: time (s), column 2 (without a title), force (N))"),
    ],
)
def test_columns_are_listed_by_what_they_are_called(tmp_path, titles, told):
    path = tmp_path / "rig.csv"
    path.write_text(titles + "\n1,2,3,\n2,3,5,\n4,4,6,\n5,6,8,\n", encoding="utf-8")
    with pytest.raises(DataError) as asked:
        open_in_time(path) or open_measurement(path)
    assert told in str(asked.value)
