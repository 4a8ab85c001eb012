"""The built-in plugins keep the contracts that authors of plugins are given."""

from __future__ import annotations

import os
from pathlib import Path
from typing import ClassVar

import pytest

from springpot.errors import DataError
from springpot.measurement import pick_reader
from springpot.registry import plugins
from springpot.testing import PluginContract

SHARED = Path(
    os.environ.get("SPRINGPOT_DATA", "").split(os.pathsep)[0]
    or Path(__file__).parents[3] / "shared" / "data"
)
SIGNALS = b"time [s],displacement [mm],force [N]\n" + b"".join(
    b"%.2f,%.6f,%.6f\n" % (0.01 * i, (7 * i % 20) / 10 - 1, (7 * i % 20) / 5 + (3 * i % 20) / 10)
    for i in range(200)
)


def samples() -> dict[str, list[Path | bytes]]:
    """Files by the name of the reader that knows them.

    Those of the instruments are in the shared data.
    """
    found: dict[str, list[Path | bytes]] = {"signals-csv": [SIGNALS]}
    readers = list(plugins().items("reader"))
    for path in sorted((SHARED / "instrument-files").glob("*.[ct][sx][vt]")):
        try:
            found.setdefault(pick_reader(path, readers).name, []).append(path)
        except DataError:
            continue
    return found


SAMPLES = samples()


@pytest.mark.soak_cases(
    "model 1s2p1d",
    "model 2s2p1d",
    "model dashpot",
    "model fractional-burgers",
    "model fractional-jeffreys-kelvin",
    "model fractional-kelvin-dashpot",
    "model fractional-kelvin-general",
    "model fractional-maxwell-dashpot",
    "model fractional-maxwell-general",
    "model fractional-poynting-thomson-general",
    "model fractional-solid",
    "model fractional-zener-general",
    "model fractional-zener5",
    "model havriliak-negami",
    "model huet",
    "model huet-sayegh",
    "model jeffreys",
    "model jeffreys-kelvin",
    "model kelvin-N",
    "model maxwell",
    "model maxwell-N",
    "model oldroyd-b",
    "model power-law-plateau",
    "model prony-N",
    "model spring",
    "model zener-2",
    "model zener-kelvin",
)
class TestModels(PluginContract):
    plugin = "springpot_plugins.models"
    passive = True


@pytest.mark.soak_cases(
    "effect ageing",
    "effect arrhenius-dashpot",
    "effect arrhenius-shift",
    "effect arrhenius-springpot",
    "effect asymmetric-damping",
    "effect asymmetric-stop",
    "effect backlash-in-time",
    "effect basset",
    "effect bearing-friction",
    "effect creep-damage",
    "effect crosstalk",
    "effect cubic-damping",
    "effect damage",
    "effect dead-zone",
    "effect diffusion",
    "effect displacement-clipping",
    "effect displacement-drift",
    "effect displacement-offset",
    "effect elasto-sliding",
    "effect fading-network",
    "effect filter-mismatch",
    "effect finite-ramp",
    "effect fixture-resonance",
    "effect force-drift",
    "effect free-shift",
    "effect free-vertical-shift",
    "effect frequency-error",
    "effect gain-error",
    "effect hardening-mount",
    "effect hysteretic-loss",
    "effect intrinsic-nonlinearity",
    "effect parallel-dashpot",
    "effect parallel-spring",
    "effect parallel-springpot",
    "effect phase-error",
    "effect power-law-damper",
    "effect power-law-slip",
    "effect retardation-mode",
    "effect rig-drag",
    "effect self-heating",
    "effect series-dashpot",
    "effect series-springpot",
    "effect shear-thinning",
    "effect slack",
    "effect smooth-hysteresis",
    "effect specimen-inertia-fixed",
    "effect strain-softening",
    "effect strain-stiffening",
    "effect sudden-step",
    "effect test-shift",
    "effect thermal-force",
    "effect thermal-growth",
    "effect thermal-transient",
    "effect vertical-shift",
    "effect wlf-shift",
    "effect yielding",
)
class TestEffects(PluginContract):
    plugin = "springpot_plugins.effects"
    # Their parameter is the force at one amplitude unit per second, which is another speed in other
    # units.
    skip: ClassVar = {
        "power-law-damper": ["units"],
        "power-law-slip": ["units"],
        "yielding": ["units"],
    }


@pytest.mark.soak_cases(
    "optimiser auto",
    "optimiser basin-hopping",
    "optimiser bipop-cma-es",
    "optimiser cma-es",
    "optimiser cobyqa",
    "optimiser de-storn-price",
    "optimiser differential-evolution",
    "optimiser dual-annealing",
    "optimiser ipop-cma-es",
    "optimiser l-shade",
    "optimiser least-squares",
    "optimiser least-squares-alternating",
    "optimiser native",
    "optimiser nlopt-bobyqa",
    "optimiser nlopt-crs",
    "optimiser nlopt-direct-l",
    "optimiser nlopt-esch",
    "optimiser nlopt-isres",
    "optimiser nlopt-lbfgs",
    "optimiser nlopt-mlsl",
    "optimiser nlopt-nelder-mead",
    "optimiser nlopt-sbplx",
    "optimiser pso-paper-scalar",
    "optimiser random-search",
    "optimiser scipy-direct",
    "optimiser shgo",
)
class TestOptimisers(PluginContract):
    plugin = "springpot_plugins.optimisers"


class TestObjectives(PluginContract):
    plugin = "springpot_plugins.objectives"


@pytest.mark.soak_cases(
    "data set artificial-fractional-zener",
    "data set artificial-fractional-zener-noise1",
    "data set artificial-fractional-zener-noise2",
    "data set rheodata-linear-polymer-amplitude-sweep",
    "data set 3m-468mp-acrylic-tts",
    "data set reptate-polyisoprene-osc",
)
@pytest.mark.suite_cases(
    "",  # what is asked of the plugin as a whole
    "data set artificial-hidden",
    "data set artificial-springpot-noise1",
    "data set elastomer-epdm-70-dma-payne",
    "data set friction-damper-brfd-lehigh",
    "data set mitmaps-saos",
    "data set nist-srm2491",
    "data set polystyrene-three-tests",
    "data set reconstruction-pdms-table4-zener",
    "data set rheodata-linear-polymer-frequency-sweep",
)
class TestDataSets(PluginContract):
    plugin = "springpot_plugins.datasets"


@pytest.mark.soak_cases(
    "reader malvern",
    "reader reptate-laos",
    "reader signals-csv",
    "reader signals-mat",
    "reader ta-thermal",
    "reader trios",
    "reader trios-json",
    "reader trios-lims",
)
class TestReaders(PluginContract):
    plugin = "springpot_plugins.readers"
    samples = SAMPLES
    # Where the shared data are absent, some readers have no sample; their own tests build small
    # files.
    skip: ClassVar = {
        reader.name: ["samples"]
        for reader in plugins().items("reader")
        if not reader.text and reader.name not in SAMPLES
    }
