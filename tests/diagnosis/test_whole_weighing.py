"""What stands behind diagnoses: scans, fits, evidence, kinds of the unknown, and experiments."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_whole_diagnosis import (
    CASES,
    EXACT,
    FEW,
    MODEL,
    OMEGA,
    THETA,
    amplitudes,
    examined,
    heated,
    made,
)

from springpot.diagnosis import evidence, experiment, grown, marginal, notes, scan, verdict
from springpot.diagnosis.examination import examine
from springpot.measurement import Measurement, Units
from springpot.registry import plugins

FURTHER = {
    "moved along": (
        lambda: made(
            EXACT * (1.0 + 0.2 * np.log(OMEGA) / 5.0),
            conditions={"amplitude": np.geomspace(2.0, 0.1, 12)},
        ),
        FEW,
    ),
    "two": (lambda: made((EXACT - 0.02 * OMEGA**2) * np.exp(-3e-3j * OMEGA)), FEW[:3]),
    "a point": (lambda: made(EXACT * np.where(np.arange(12) == 6, 1.2, 1.0)), FEW[:2]),
}


@pytest.fixture(scope="module", params=[*CASES, *FURTHER])
def case(request):
    if request.param in CASES:
        return examined(request.param)
    data, names = FURTHER[request.param]
    library = [plugins().effect(name) for name in names]
    return examine(data(), MODEL, library, np.random.default_rng(3))


def of_search(search):
    """Scores of the library, grown models and the unknown of a search."""
    return {
        "scan": [search.scan.p_value, search.scan.threshold, search.gain, search.alarm],
        "scores": {
            each.influence.effect.name: [
                each.score, each.bound, each.predicted, each.directions.share,
                each.directions.length, each.directions.setting, each.starts.shape,
            ]
            for each in search.scan.scores
        },
        "grown": {
            " + ".join(each.names): [
                each.refit.log_evidence, marginal.marginal(search, each),
                marginal._refund(search, each), marginal._extras(search, each),
                evidence.log_prior(each, 5.0), each.same_at_all_amplitudes,
                len(each.effects) == 1 and each.broadens_an_order,
                [effect.name for effect in each.beyond_physics],
            ]
            for each in search.grown
            # The same twice is hardly determined.
            if len(set(each.names)) == len(each.names)
        },
        "unknown": [
            [kind.says, kind.whose, kind.drops, kind.shapes, marginal._evidence_of(search, kind)]
            for kind in marginal.unknowns(search.frame)
        ],
        "weight of it": marginal.unknown_marginal(search),
        "explaining": marginal.explaining_unknown(search) is not None,
        "left": [search.structure.p_value, search.left.p_value, search.repeats.p_value],
        "pairs": [
            [pair.first.influence.effect.name, pair.second.influence.effect.name, pair.start]
            for pair in scan.best_pairs(
                search.frame, search.scan.scores, search.base.model, search.base.theta, 3
            )
        ],
        "drift": grown.drift_in_place(search),
    }  # fmt: skip


def of_evidence(found):
    return {
        "chances": [found.nothing, found.unknown, found.effects, found.narrow, found.other_shape],
        "sets": [[one.names, one.probability, one.one_spectrum] for one in found.explanations],
        "named": [
            sorted(found.imitators), sorted(found.leaning), sorted(found.moved), found.drift,
            found.one_frequency,
        ],
        "classes": found.classes,
        "leading": [found.leader, found.rivals, found.partners] if found.explanations else [],
        "doubted": [found.doubted(p).unknown for p in (1.0, 0.05, 1e-4, 0.0)],
    }  # fmt: skip


@pytest.mark.soak_cases("moved along", "a point")
def test_what_is_weighed(case, stays):
    facts = verdict.facts_of(case.evidence, case.outliers, case.naming is not case.search)
    stays(
        {
            "facts": facts,
            "rule": verdict.rule_for(facts).reason,
            "evidence": of_evidence(case.evidence),
            "confounded": [each.names for each in case.naming.confounded],
            **of_search(case.naming),
        },
        within=2e-3,
    )


MEASURED = {
    "plain": lambda: made(EXACT),
    "strained": amplitudes,
    "heated": heated,
    "cold": lambda: replace(heated(), conditions={"temperature": np.repeat([-175.0, -100.0], 12)}),
    "of a sample": lambda: Measurement(OMEGA, EXACT, units=Units("kPa", "-")),
    "one frequency": lambda: Measurement(np.full(3, 6.0), EXACT[:3], units=Units("N/m", "m")),
    "many": lambda: Measurement(
        np.geomspace(1.0, 100.0, 150), MODEL.stiffness(THETA, np.geomspace(1.0, 100.0, 150))
    ),
}


@pytest.mark.parametrize("name", list(MEASURED))
def test_what_could_be_measured_next(name, stays):
    stays(
        [
            {key: value for key, value in vars(action).items() if key != "points"}
            | {
                "points": [
                    action.points.log_omega,
                    action.points.amplitude,
                    action.points.temperature,
                ]
            }
            for action in experiment.actions(MEASURED[name]())
        ]
    )


def test_a_measurement_is_promised_in_words(stays):
    pairs = [(0.05, 0.05), (1.0, 2.0), (1.0, 2.1), (9.0, 3.0), (2000.0, 1500.0), (0.1, 2000.0)]
    stays(
        [
            [
                experiment.promise(("a", "b"), shares, sigmas),
                experiment.separation(shares, sigmas),
                experiment._no_use(action.says, ("a", "b"), sigmas[0]),
                experiment._enough(sigmas[1]),
            ]
            for action in list(experiment.actions(made(EXACT)))[:1]
            for shares in ((0.5, 0.5), (0.9, 0.1))
            for sigmas in pairs
        ]
    )


@pytest.mark.parametrize("grows", [0.0, 1.0, 2.0])
def test_overtones_are_told_above_the_noise(grows, stays):
    data = amplitudes()
    x = data.conditions["amplitude"]
    share = 0.02 * x**grows
    third = (share * np.exp(0.3j))[:, None] * np.array([0.1, 1.0, 0.01, 0.3])
    overtones = replace(data, harmonics=third.astype(complex))
    found = notes.overtones(overtones, 0.005 * np.abs(data.stiffness) * (1 + 1j))
    stays({"found": found, "judged": notes.judged(found)})
