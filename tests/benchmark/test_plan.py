"""Plans: what a trial is known by, and where its randomness comes from."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from benchmark_fakes import OMEGA, TRUTH, Walk, artificial, measurement, small_study

from springpot import parse_model, plugins
from springpot.benchmark import Store, Study, run_study
from springpot.benchmark.plan import BLOCK, cell_digest, digest_of, stream_of
from springpot.errors import DataError, ModelError, StudyError
from springpot.identification import Problem, run
from springpot.identification.runs import BatchedOptimiser


@dataclass(frozen=True)
class Herd(BatchedOptimiser):
    """Many walks at once."""

    name = "herd"
    card = Walk.card

    def minimise_batch(self, problems, budget, rngs):
        for recorder, rng in zip(problems.recorders, rngs, strict=True):
            recorder(rng.random(recorder.dimension))


def digests(study):
    return [cell.digest for cell in study.plan().cells]


def test_the_digest_depends_on_everything_that_a_result_depends_on():
    base = small_study(datasets=[artificial()], models=["own"], optimisers=[Walk()])
    (reference,) = digests(base)
    assert digests(base) == [reference]
    assert digests(base.with_options(repeats=9)) == [reference]
    others = [
        base.with_options(budget=301),
        replace(base, seed=2),
        replace(base, objectives=["log"]),
        replace(base, models=["springpot"]),
        replace(base, optimisers=[Walk(shrink=0.5)]),
        replace(base, datasets=[artificial(0.01)]),
        replace(base, datasets=[replace(artificial(), stiffness_scale=500.0)]),
        replace(base, stop_at_target=True),
    ]
    found = [digests(study)[0] for study in others]
    assert len({reference, *found}) == 1 + len(others)


def test_a_label_or_a_limit_does_not_change_the_trial():
    base = small_study(datasets=[artificial()], models=["own"], optimisers=[Walk()])
    assert digests(
        replace(base, optimisers=[("mine", Walk())], deadline=1.0, memory=64)
    ) == digests(base)


def test_the_digest_of_data_sees_every_column():
    data = measurement()
    variants = [
        replace(data, omega=OMEGA * (1 + 1e-6)),
        replace(data, sd=np.full(len(OMEGA), 1 + 1j)),
        replace(data, conditions={"temperature": np.full(len(OMEGA), 20.0)}),
        replace(data, conditions={"amplitude": np.full(len(OMEGA), 20.0)}),
        replace(data, repeat=np.ones(len(OMEGA), dtype=np.int64)),
    ]
    assert len({item.digest() for item in [data, *variants]}) == 6
    assert replace(data, name="other").digest() == data.digest()


def test_last_bits_of_what_is_worked_out_of_data_leave_the_digest():
    plan = small_study(datasets=[artificial()], models=["own"], stop_at_target=True).plan()
    case, entrant, stop = plan.cases[0], plan.entrants[0], 0.1

    def digest(scale, value):
        source = replace(case.source, stiffness_scale=scale)
        return cell_digest(replace(case, source=source), entrant, 60, 1, value)

    assert digest(0.1 * 3, np.nextafter(stop, 1.0)) == digest(0.3, stop)
    others = [
        digest(0.3, 0.100001),
        digest(0.300001, stop),
        digest(None, stop),
        digest(0.3, -np.inf),
    ]
    assert len({digest(0.3, stop), *others}) == 5


def test_neighbouring_parts_of_a_digest_do_not_run_together():
    assert digest_of("ab", "c") != digest_of("a", "bc")
    assert digest_of(1) != digest_of("1")


def test_optimisers_share_their_random_numbers_and_nothing_else_does():
    plan = small_study().plan()
    states = {}
    for cell in plan.cells:
        for repetition in range(2):
            key = (cell.case, repetition)
            state = tuple(np.random.default_rng(plan.stream(cell, repetition)).random(4))
            assert states.setdefault(key, state) == state
    assert len(set(states.values())) == len(states) == len(plan.cases) * 2


def test_streams_do_not_depend_on_what_else_is_in_the_study():
    whole, part = small_study().plan(), small_study(datasets=[artificial(0.02, "noisy")]).plan()
    theirs = {c.digest: whole.stream(c, 1).entropy for c in whole.cells}
    ours = {c.digest: part.stream(c, 1).entropy for c in part.cells}
    assert ours.items() <= theirs.items()
    assert stream_of(1, "a", "b").entropy != stream_of(1, "b", "a").entropy


def test_only_what_is_missing_is_to_be_done():
    plan = small_study(repetitions=3).plan()
    tasks = list(plan.tasks(lambda cell: {0, 2} if cell.index else {0, 1, 2}))
    assert sorted((task.cell, task.repetitions) for task in tasks) == [
        (i, (1,)) for i in range(1, len(plan.cells))
    ]


def test_the_work_goes_from_optimiser_to_optimiser():
    """A worker serves one of them, so that the fewest possible have to be forked."""
    plan = small_study(repetitions=3).plan()
    entrants = [plan.cells[task.cell].entrant for task in plan.tasks(lambda cell: set())]
    assert entrants == sorted(entrants)
    assert len(set(entrants)) == 2


def test_one_run_of_an_optimiser_without_chance_stands_for_a_block(tmp_path):
    """DIRECT does the same whatever the stream; its repetitions are kept, but computed once."""
    study = small_study(
        datasets=[artificial(0.02)], models=["own"], optimisers=["nlopt-direct-l"], repetitions=3
    )
    assert [task.repetitions for task in study.plan().tasks(lambda cell: {1})] == [(0, 1, 2)]
    outcome = run_study(study, engine="serial", out=tmp_path, quiet=True)
    with Store(outcome.store) as store:
        ((_, rows),) = store.trials()
    assert [row.repetition for row in rows] == [0, 1, 2]
    assert len({replace(row, repetition=0).__repr__() for row in rows}) == 1
    problem = Problem.of(
        parse_model("fractional-kelvin"), artificial(0.02).open(), study.plan().cases[0].objective
    )
    alone = run(
        plugins().find("optimiser", "nlopt-direct-l")(),
        problem,
        study.budget,
        np.random.default_rng(7),
    )
    assert alone.best == rows[0].best


def test_a_batched_optimiser_gets_in_blocks_what_is_not_done():
    plan = small_study(
        datasets=[artificial()], models=["own"], optimisers=[Herd()], repetitions=BLOCK + 2
    ).plan()
    blocks = [task.repetitions for task in plan.tasks(lambda cell: {0, 1})]
    assert blocks == [tuple(range(2, BLOCK)), (BLOCK, BLOCK + 1)]
    assert [t.repetitions for t in plan.tasks(lambda cell: set(range(BLOCK)))] == [
        (BLOCK, BLOCK + 1)
    ]


def test_own_and_a_mapping_pair_data_with_models():
    study = small_study(models={"noisy": ["springpot", "fractional-kelvin + inertia"]})
    pairs = [(case.source.name, case.model) for case in study.plan().cases]
    assert pairs == [
        ("kelvin", "fractional-kelvin"),
        ("noisy", "springpot"),
        ("noisy", "fractional-kelvin + inertia"),
    ]


def test_the_value_at_the_truth_is_known_for_the_true_model_only():
    cases = small_study().plan().cases
    known = {(case.source.name, case.model): case.known for case in cases}
    assert known["kelvin", "fractional-kelvin"] < 1e-20 * cases[0].reference
    assert 0 < known["noisy", "fractional-kelvin"] < 1e-2 * cases[0].reference
    assert known["kelvin", "springpot"] is None
    assert small_study(datasets=[measurement()], models=["springpot"]).plan().cases[0].known is None


def test_labels_show_the_options_that_differ():
    plan = small_study(optimisers=[Walk, Walk(shrink=0.5), ("mine", Walk(shrink=0.1))]).plan()
    assert [entrant.label for entrant in plan.entrants] == ["walk", "walk(shrink=0.5)", "mine"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": "a/b"}, "study name 'a/b'"),
        ({"datasets": "kelvin"}, "datasets must be a list"),
        ({"optimisers": []}, "optimisers must be a list with at least one"),
        ({"budget": 0}, "budget must be a whole number from 1 on, not 0"),
        ({"budget": 2.5}, "budget must be a whole number from 1 on, not 2.5"),
        ({"repetitions": True}, "repetitions must be a whole number from 1 on, not True"),
        ({"repetitions": "3"}, "repetitions must be a whole number from 1 on, not '3'"),
        ({"memory": float("nan")}, "memory must be a whole number from 1 on, not nan"),
        ({"deadline": float("inf")}, "deadline must be a positive number, not inf"),
        ({"seed": "x"}, "seed must be a whole number, not 'x'"),
        ({"finish": 3}, "finish must be a function of two paths, not 3"),
        ({"datasets": [artificial(), artificial()]}, "data set 'kelvin' occurs twice"),
        ({"optimisers": [Walk(), Walk()]}, "optimiser 'walk' occurs twice"),
        ({"optimisers": [Walk(), ("again", Walk())]}, "occurs twice"),
        ({"datasets": [measurement()], "models": ["own"]}, "kelvin has no model of its own"),
        ({"optimisers": [Walk(shrink=len)]}, "option walk.shrink is a builtin_function_or_method"),
        ({"models": {"kelvim": ["springpot"]}}, "models are given for 'kelvim'"),
        ({"optimisers": [3]}, "3 is no optimiser"),
        ({"asks": ["who is first?"]}, "asks must be 3 sentences: question, measure, what would"),
        ({"objectives": ["own"]}, "kelvin has no objective of its own: name one"),
    ],
)
def test_a_study_that_cannot_be_is_one_line(changes, message):
    with pytest.raises(StudyError, match=message) as caught:
        small_study(**changes).plan()
    assert "\n" not in str(caught.value)


def test_whole_numbers_are_the_same_study_however_they_are_written():
    plain = small_study(repetitions=2, budget=100, seed=3).plan()
    other = small_study(repetitions=np.int64(2), budget=1e2, seed=np.int64(3)).plan()
    assert other.cells == plain.cells
    assert (other.repetitions, repr(other.budget)) == (2, "100")


def test_unknown_names_are_one_line():
    with pytest.raises(ModelError, match="unknown model 'kelvinn'"):
        small_study(models=["kelvinn"]).plan()
    with pytest.raises(DataError, match="no-such-data"):
        small_study(datasets=["no-such-data"]).plan()


def test_a_study_needs_no_more_than_names():
    study = Study("named", [artificial()], ["own"], ["paper"], [Walk], repetitions=1, budget=10)
    assert study.plan().size == 1
    assert study.plan().cases[0].source.truth == TRUTH


NUMBERS = {
    "deadline": 6,
    "target": np.float64(0.5),
    "accuracy": 1,
    "budget": 3e2,
    "repetitions": np.int64(4),
}


def test_a_number_is_one_number_however_it_is_written():
    """As Python's own float or int.

    What is sealed is what the store gives back, and digests are made of JSON.
    """
    study = small_study(
        **NUMBERS, memory=np.float64(2048), seed=np.int32(1), stop_at_target=np.False_
    )
    plain = small_study(deadline=6.0, target=0.5, accuracy=1.0, budget=300, repetitions=4)
    for key in (*NUMBERS, "memory", "seed", "stop_at_target"):
        assert type(getattr(study, key)) is type(getattr(plain, key)), key
        assert repr(getattr(study, key)) == repr(getattr(plain, key))
    scales = [replace(artificial(), stiffness_scale=scale) for scale in (500, 500.0, np.int64(500))]
    truths = [replace(artificial(), truth={**TRUTH, "k": k}) for k in (100, 100.0, np.float32(100))]
    for alike in (scales, truths):
        assert len({tuple(digests(small_study(datasets=[data]))) for data in alike}) == 1


@pytest.mark.parametrize(
    "change", [{"seed": True}, {"budget": True}, {"deadline": True}, {"stop_at_target": "no"}]
)
def test_a_truth_is_no_number_and_a_word_no_truth(change):
    (key,) = change
    with pytest.raises(StudyError, match=f"{key} must be"):
        small_study(**change)
