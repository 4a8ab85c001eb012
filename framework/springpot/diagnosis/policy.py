"""Every level of the diagnosis, in one place, each with its reason: a source, a false alarm, or what it guards.

Chances of a false alarm are measured by ``studies/hidden_effect.py`` on data from which nothing is missing.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log, pi, sqrt


@dataclass(frozen=True)
class ScatterLevels:
    """Scatter about a fit, where the noise must be estimated from it."""

    most_ripples: int = 2
    """Periods that are taken out of the scatter; a third could follow noise."""
    ripple_alarm: float = 0.0001
    """Chance of white noise whose strongest period is as strong as one that is taken out."""
    slowest_ripple: float = 16.0
    """Points of the longest period: longer waves are slow structure already."""
    slow_waves: int = 2
    """Waves along a sweep up to which its polynomials of degree 5 are that structure, however many its points."""
    least_new: float = 0.001
    """Share of a curve that those already taken out must leave for it to count."""
    fewest_free: float = 20.0
    """Degrees of freedom below which a period would take too many of them."""
    least_kept: float = 0.7
    """Share of the data below which what is left out is no few frequencies any more."""
    outlying_frequency: float = 0.0002
    """Chance below which the scatter at one frequency is held to be no noise."""
    rounds: int = 2
    """Times that the noise is estimated anew about the fit that it gave."""
    trimmed_fits: int = 6
    """Fits without what stands out, each beside the last: of the notches tried nearly all settle in three."""
    sharper: float = 0.7
    """The noise is estimated anew where the scatter about the best model is less than this share of the
    estimate."""
    differences: tuple[int, int, int, int] = (2, 3, 4, 5)
    """Orders of the differences: of a ripple of 8 points the second leave 59 % and the fifth 26 % of its size.
    Those of order k are worth C(2k,k)^2 / C(4k,2k) degrees of freedom each, as neighbouring ones share points."""
    enough_neighbours: int = 10
    """Degrees of freedom below which second differences say too little."""
    faster_alarm: float = 0.001
    """Chance that second differences vary by so much less than the scatter if that is noise."""
    fewest_about_model: int = 4
    """Degrees of freedom from which the scatter about a model says how large the noise is."""
    dealt_alone: int = 8
    """Points of a sweep from which its scatter is dealt out anew by itself."""
    fewest_rough: int = 8
    """Degrees of freedom that slow curves leave to the scatter at least: its size is then known to a quarter."""
    fewest_own: float = 20.0
    """Degrees of freedom below which a scatter says too little of itself."""


SCATTER = ScatterLevels()


@dataclass(frozen=True)
class SweepsLevels:
    """Sweeps, and what counts as slow along them."""

    smooth_degree: int = 5
    """Highest degree of the slow polynomials along a sweep that count as structure rather than as noise."""
    fewest_alike: int = 3
    """Sweeps in which a residual must be alike to count as structure rather than as noise."""
    most_shared: int = 60
    """Frequencies above which sweeps are dense enough for their neighbours to show what is shared."""
    drift_degree: int = 3
    """Degree of the polynomials by which a gain or a phase may creep from row to row."""


SWEEPS = SweepsLevels()


@dataclass(frozen=True)
class BatteryLevels:
    """Tests on the residual of a fit."""

    draws: int = 2000
    """Simulated residuals of noise alone; the chance 0.005 is then known to a third of itself."""
    edge: tuple[float, float] = (0.001, 0.006)
    """Between these chances lie the alarms: there the verdict must not be left to the seed."""
    sure: float = 3.5
    """Standard errors of a chance beyond that edge from which no more draws are needed."""
    further: tuple[int, ...] = (3, 6)
    """So many times as many draws more while that is open; with all of them 0.005 is known to a tenth of itself."""
    fewest_repeats: int = 8
    """Repeated points below which nothing can be said of how repeats differ."""
    fewest_off_mains: int = 10
    """Points away from the mains from which their scatter can be held against that at the mains."""
    near_mains: float = 0.015
    """Relative distance from a multiple of the mains at which its hum leaks into a sinusoid of some ten periods."""
    least_trend: float = 1e-3
    """Relative spread of a condition, and share of a trend that the parameters leave, below which there is none."""
    least_local: float = 0.1
    """Share of a narrow shape that the parameters must leave: less of a single point is their own noise."""
    most_local: int = 600
    """Narrow shapes looked at; more points than these have slow structure enough."""


BATTERY = BatteryLevels()


@dataclass(frozen=True)
class ScanLevels:
    """Scores of the library, before anything is refitted."""

    small: tuple[float, float] = (1e-05, 0.15)
    """Relative changes of K that count as small: there a direction is a tangent."""
    absorbed: float = 0.001
    """A direction of which less than this is left after projection cannot be seen in these data."""
    settings_of_one: int = 64
    """Settings of an effect of one parameter, over all that is physically possible."""
    settings_of_more: int = 96
    """Settings of an effect of more parameters, beside those for each further one."""
    settings_of_each: int = 160
    """Settings for each further parameter, of a sequence that fills space evenly."""
    per_effect: int = 64
    """Directions kept of one effect: its grid is finer than the data resolve."""
    draws: int = 3000
    """Simulated residuals, jointly for all effects."""
    whole_starts: int = 3
    """Settings of the grid from which a refit starts beside the tangent."""
    power: float = 1.645
    """One-sided normal quantile of the 95 % power at which bounds are stated."""
    representatives: int = 10
    """Directions kept for each effect: the best one, and those least alike it and each other."""
    parallel: float = 0.9995
    """Directions more alike than this are one direction."""


SCAN = ScanLevels()


@dataclass(frozen=True)
class SearchLevels:
    """Which grown models are fitted."""

    singles: int = 12
    """Effects refitted after the first scan."""
    beam: int = 4
    """Single effects from which a second one is sought."""
    seconds: int = 4
    """Second effects refitted for each of them."""
    together: int = 8
    """Pairs refitted that explain the residual only together."""
    look_further: float = 0.05
    """Chance of a false alarm from which on grown models are judged by what they leave: ten times the verdict's."""
    left_over: float = 0.2
    """Chance of noise below which the best single effect may leave something, and pairs are tried: a pair that is
    tried in vain costs time, one that is not tried costs the answer."""
    resolved: float = 3.0
    """Points over which a narrow effect must spread at least."""
    common: float = 1.0
    """Prior weight below which an effect alone is not taken for an answer before pairs of common ones are tried."""
    suspicious: float = 0.01
    """Chance of a false alarm below which it is asked whether single points raise it."""
    tried_alone: int = 3
    """Grown models whose parameters are tried for the model alone."""
    negligible: float = 1e-6
    """Share of chi-square that is not worth another step of a refit: 0.001 for a thousand numbers, where evidence
    is weighed in tenths."""
    hopeless: float = 0.5
    """Share of what the best grown model explains below which another one, after its first ten steps, is no rival and
    is not searched further. Of 60 artificial cases all verdicts and 58 leading classes stay as they were."""
    better: float = 0.5
    """Gain in log-likelihood from which a fit has found another minimum."""
    decisive: float = 10.0
    """Drop of the information criterion that is beyond doubt, ten by Kass and Raftery (1995,
    doi:10.1080/01621459.1995.10476572): from it the best model tells the noise, and an effect is accepted without
    asking."""
    no_influence: float = 1e-06
    """Relative change of K per relative change of a parameter below which the parameter is without influence."""


SEARCH = SearchLevels()


@dataclass(frozen=True)
class EvidenceLevels:
    """What a model's parameters cost, and prior odds."""

    credible: float = 0.93
    """A class holds at least this share of the probability of all explanations."""
    one_curve: float = 0.35
    """Curves this close (root mean square, in units of the noise) are one curve for these data."""
    most_unknown: float = 1.0 - 1e-12
    """Nothing is ever certain to be unknown: the rest of the sum would be lost."""
    rounding: float = 1e-06
    """Log-evidence that says nothing."""
    prior_nothing: float = 0.5
    """Chance, before the data, that nothing is missing: even odds."""
    prior_pair: float = 0.5
    """Prior weight of a second missing effect; pairs have no order, so that two against one weigh half of it."""
    outside: float = 0.15
    """Chance, before the data, that what is missing is in no library."""
    beside: float = 0.9
    """Probability from which something is missing beside the leading effect."""
    other_narrow: float = 0.3
    """Share of a narrow effect's probability that goes to narrow features of another origin."""
    unknown_size: float = log(10.0 * log(10.0) / sqrt(2.0 * pi))
    """Cost of a size that may lie anywhere in ten decades."""
    unknown_sign: float = log(2.0)
    """Cost of a size that may be positive or negative."""
    vague: float = 10.0
    """Square of the relative width within which a parameter other than a size is known beforehand."""
    rivals: float = 6.0
    """Log-likelihood within which a model rivals the best one, whatever its parameters cost."""
    open: float = 0.3
    """Relative variance from which a parameter is held to be left open by the data."""
    least_influence: float = 1.0
    """Change of K over the noise, per natural unit of a parameter, below which its effect does without it."""
    places: int = 9
    """Places in its range at which an open parameter is held in turn."""
    least_share: float = 0.02
    """Share of its range below which a parameter is not open."""
    harmonic_tolerance: float = 0.3
    """Share by which a predicted harmonic may be off: describing functions hold the displacement to be a sinusoid,
    which no rig makes it."""
    least_harmonic: float = 0.002
    """Share of the first harmonic below which a third one is held to be the rig's."""
    most_harmonic_rows: float = 10.0
    """Rows that count at most: what is wrong with a prediction is wrong in all of them."""
    unpredicted_harmonic: float = -3.0
    """Log-likelihood where an effect makes harmonics of which neither a formula nor a bound is known."""
    creep_degree: int = 3
    """Degree of the polynomials by which a gain or a phase may change over the measurement."""
    prior_chain: float = 0.5
    """Prior weight of each fault of a measuring chain beside that of a common effect."""
    settling_times: tuple[float, ...] = (0.03, 0.06, 0.12, 0.25, 0.5, 1.0)
    """Times, in durations of the measurement, in which a rig may settle; slower ones are a straight line."""
    least_seen: float = 1e-3
    """Share of a shape that the parameters must leave for it to be seen."""
    fewest_levels: int = 3
    """Levels of a condition from which a gain of its own at each is no other name for a trend."""
    points_of_each: int = 4
    """Points of each level at least, so that the levels do not follow the noise."""
    most_steps: int = 200
    """Places at which a step is sought at most, evenly over the measured frequencies."""
    as_good: float = 3.0
    """Log-evidence by which an explanation may be worse and count as good: odds of one to twenty."""


EVIDENCE = EvidenceLevels()


@dataclass(frozen=True)
class VerdictLevels:
    """From evidence to a word."""

    arithmetic: float = 2e-5
    """Error that no instrument reaches: data nearer to a model were computed. The lines of a free spectrum follow a
    smooth one to 5e-6."""
    neighbours: float = 0.05
    """Chance that the points of an error beyond the floor lie side by side. Noise with long tails (Student's t, three
    degrees of freedom) has such an error in 3 of 40 data sets: it is called structure in one of 250."""
    library_alarm: float = 0.006
    """Chance of a false alarm granted to the scan of the library."""
    structure_alarm: float = 0.005
    """Chance of a false alarm granted to the test for structure of any kind."""
    beyond_doubt: float = 0.002
    """Chance of a false alarm below which something is missing even if the evidence names it weakly."""
    remainder: float = 0.005
    """Share of the misfit that named effects may leave and still be the verdict."""
    small_rest: float = 2.0
    """Error of the best model over the noise floor up to which what it leaves is small beside the noise."""
    noisy: float = 1.2
    """Error over noise floor below which only the pattern of a misfit tells it from noise."""
    nothing_left: float = 10.0
    """Chi-square beyond the degrees of freedom that is no misfit worth a verdict."""
    fewest_spare: int = 4
    """Degrees of freedom below which data cannot be judged."""
    harmonic_alarm: float = 0.05
    """Chance that any harmonic of the force is held to be real where all are noise."""
    drift_share: float = 0.75
    """Share of what sets repeats apart from which one slow curve in time is its cause: 0.49 to 0.64 for replicates of
    three bitumen specimens (fhwa-ptf-binder-dsr), 0.88 for an artificial drift."""
    repeats_alarm: float = 0.002
    """Chance of a false alarm granted to the test of the repeats' scatter."""
    likely: float = 0.5
    """Probability from which an effect of the first class is called missing."""
    clear_evidence: float = 6.0
    """Drop of the information criterion from which something counts as missing."""
    misfit: float = 1.3
    """Error over noise floor from which a fit does not hold."""
    seen: float = 0.05
    """Relative change of K: an effect that would have been seen at this size is called absent."""
    worth_a_word: float = 0.03
    """Probability from which narrow features of unknown origin are told of."""
    explained: float = 1.5
    """Chi-square per degree of freedom up to which nothing worth a word is left."""
    most_of_it: float = 0.2
    """Share of a misfit beyond the noise that may be left by what is said to explain most of it."""
    loud: float = 0.01
    """Share of the first harmonic from which a higher one is told of: less is the rig's."""
    takes_most: float = 0.5
    """Share of an error that an effect leaves at most to be named in the headline though something is left."""
    most_alike: int = 3
    """Effects of which one is so named at most: of more the headline would not be one."""
    mostly: float = 0.8
    """Share of a misfit, in chi-square, from which it is told as being all of one kind."""
    close_power: float = 0.35
    """A slope this near one of these powers is called by its name."""
    spread: float = 1.5
    """Largest over smallest amplitude from which a slope is worth saying."""
    agrees: float = 1.5
    """Ratio up to which two values are said to agree."""


VERDICT = VerdictLevels()


@dataclass(frozen=True)
class OutliersLevels:
    """Single points that stand out."""

    rare: float = 0.0001
    """Chance that the largest of all points is held to stand out where all is noise."""
    most: float = 0.05
    """Share of the points that may stand out; more are no outliers but structure."""
    fewest_points: int = 12
    """Points below which none can be held to stand out."""
    least_left: float = 0.1
    """A point of which less than this share is free of the fitted curves says nothing by itself."""
    heavier: float = 3.0
    """Log-likelihood by which the others must speak for long tails before a point that is far off is held to be
    one."""
    carries: float = 0.5
    """Share of what a fit leaves from which one point is suspected of having bent it: of 12 points of noise one
    carries half in 7 of 1,000 data sets, of 16 in 1 of 2,000."""
    settles: float = 0.1
    """Share of the misfit that may be left without such a point: less, and it was the point."""
    price: float = 5.0
    """Log-odds against a point being an outlier, beside the one in n for which point it is."""


OUTLIERS = OutliersLevels()


@dataclass(frozen=True)
class WhereLevels:
    """Places at which a model fails."""

    alarm: float = 0.003
    """Chance that noise alone makes a place of one part of K."""
    bands: tuple[int, int, int] = (24, 12, 6)
    """Intervals at most along each of one, two or three axes, when the place of a misfit is sought."""
    most: int = 5
    """Places told of at most: the most telling ones."""
    slight: float = 0.1
    """Share of the clearest place's standard deviations below which a place is not worth a sentence beside it."""
    one_period: float = 0.4
    """Share of the power beyond the noise's that lies at one period if a misfit is a ripple."""
    most_blocks: int = 12
    """Blocks taken out at most."""
    whole: float = 0.8
    """Share of its points that a block must still hold, or it would describe those that are already told of."""
    draws: int = 120
    """Simulated residuals; the tail beyond them is fitted."""
    few: int = 12000
    """Points of all simulated residuals together up to which there are more of them: a rough threshold errs much
    where few points tell their own noise."""
    scales: int = 2000
    """Values of the scale of the noise for which the chance of a residual is averaged."""
    swept: float = 10.0
    """Span, in units of how nearly a rig holds a value, from which close values are a sweep, not a drift."""
    levels_differ: float = 0.01
    """Chance below which levels are held to differ."""
    alike: float = 0.3
    """Share of a misfit by which it may differ between levels and be called the same."""
    close_power: float = 0.25
    """Distance of an exponent from a whole one at which it is called by it."""


WHERE = WhereLevels()


@dataclass(frozen=True)
class LeftoverLevels:
    """What the best model leaves."""

    alarm: float = 0.001
    """Chance of noise alone below which something is held to be seen."""
    nothing: float = 0.01
    """Chance of noise alone above which nothing is held to be seen."""
    small: float = 0.25
    """Share of the misfit of a rival description that may be left by the one that is named."""
    least_shift: float = 0.7
    """Range of ln a_T below which fixed and moving cannot be told apart."""
    resolved: float = 0.001
    """Share of a shape that the others must leave for it to count."""
    sure: float = 10.0
    """Log-evidence from which a residual is called causal, or not."""
    fewest: int = 10
    """Second differences from which they tell the scatter."""
    narrow: int = 8
    """Narrow resonances that are tried for each point of a sweep."""
    beyond: float = 5.0
    """Range of ln omega beyond the data in which bumps may lie."""
    most_beside: int = 25
    """Bumps beyond each end of the data at most."""
    most_steps: int = 60
    """Steps along the frequency at most."""


LEFTOVER = LeftoverLevels()


@dataclass(frozen=True)
class LevelsLevels:
    """Each temperature by itself."""

    fewest: int = 3
    """Levels from which one can stand out from the others."""
    points: int = 6
    """Points of a level from which a free spectrum can fail at it."""
    stands_out: float = 2.0
    """Error over the median of all levels from which a level is no material: the same rig, specimen and noise."""
    alarm: float = 0.001
    """Chance by scatter alone below which a level, or a shift, is said to fail."""
    worse: float = 1.3
    """Error of all levels together over that of each alone from which a shift fails: as the misfit of a model."""
    told: int = 3
    """Levels that are named in a sentence."""


LEVELS = LevelsLevels()


@dataclass(frozen=True)
class ValidationLevels:
    """Prediction of what was left out."""

    better: float = 0.98
    """Share of an error from which on a smaller one is better."""
    folds: int = 4
    """Levels or bands left out at most, each by itself."""
    points_of_each: int = 4
    """Points of each level at least: of fewer one says little."""
    fewest_levels: int = 4
    """Levels from which two inner ones can be left out between others."""
    least_seen: float = 0.1
    """Share of a level's residual that the other levels must leave along an axis, or they do not predict it."""
    bands: int = 6
    """Bands into which a condition that was swept is divided, or the frequency where no condition differs."""


VALIDATION = ValidationLevels()


@dataclass(frozen=True)
class ExperimentLevels:
    """What could be measured next."""

    points: int = 20
    """Points of a new sweep."""
    denser: int = 4
    """How many times as many frequencies, or repeats, an action takes as there were."""
    most_points: int = 400
    """Points of a denser sweep at most."""
    steps: tuple[float, float] = (20.0, 40.0)
    """Kelvin by which the range of temperatures is widened at least and at most."""
    coldest: float = -180.0
    """Temperature in degC that liquid nitrogen reaches in a test chamber."""
    evaluations: int = 40
    """Evaluations of a fit of one explanation to the other."""
    far: float = 1000000000.0
    """Stands for a difference beyond all numbers."""
    tried: int = 3
    """Actions that are fitted in earnest at most."""
    telling: float = 2.0
    """Separation below which a measurement is not worth its effort: the odds hardly change."""
    settled: float = 5.0
    """Separation in standard deviations that settles the matter."""
    rival: float = 0.001
    """Chance, beside that of the leading effect, from which another is worth a measurement."""


EXPERIMENT = ExperimentLevels()


@dataclass(frozen=True)
class LadderLevels:
    """Effects accepted without asking."""

    clear: float = 0.001
    """Chance of a false alarm below which an effect is accepted without asking."""
    decisive: float = 10.0
    """As for the noise: a drop of ten is beyond doubt (Kass and Raftery 1995)."""
    hidden: int = 2
    """Effects that may be accepted from an unexplained rung on, if they complete the model."""
    predicts: float = 0.7
    """Error of prediction, over that of the rung before, up to which an effect stays though the rest is
    unexplained."""
    longest: int = 6
    """Effects accepted at most."""


LADDER = LadderLevels()
