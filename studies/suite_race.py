"""Twenty-four optimisers on the sixty problems of springpot-60."""

from __future__ import annotations

from springpot.benchmark import Study

RIVALS = (
    *("least-squares", "dfo-ls", "nlopt-lbfgs", "basin-hopping", "minuit-migrad"),
    *("nlopt-mlsl", "nlopt-bobyqa", "nlopt-nelder-mead", "nlopt-sbplx", "dual-annealing"),
    *("cma-es", "bipop-cma-es", "differential-evolution", "l-shade", "minion-jso", "minion-arrde"),
    *("pso-paper", "spso-2011", "nlopt-crs", "nlopt-isres", "nlopt-esch"),
    *("nlopt-direct-l", "scipy-direct", "random-search"),
)

study = Study(
    "suite_race",
    datasets=["springpot-60"],
    models=["own"],
    objectives=["own"],
    optimisers=RIVALS,
    repetitions=2,
    budget=8000,
    stop_at_target=True,
)

if __name__ == "__main__":
    study.main()
