"""The accuracy gate of this repository: a few optimisers on a few problems, in seconds.

    springpot regression check studies/gate.py

compares with ``results/gate/baseline.json``. After a change that is meant: ``springpot regression
update``, commit.
"""

from springpot.benchmark import Study

study = Study(
    "gate",
    datasets=[
        "artificial-springpot",
        "artificial-fractional-maxwell",
        "artificial-fractional-zener",
    ],
    models=["own"],
    objectives=["paper"],
    optimisers=["pso-paper", "cma-es", "nlopt-crs", "native"],
    repetitions=20,
    budget=6000,
    target=1e-7,
    stop_at_target=True,
)

if __name__ == "__main__":
    study.main()
