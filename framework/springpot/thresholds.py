"""Every level that decides, each with its reason: a source, a false alarm, or what it guards.

How finely something is computed stands beside the function that does so. Chances of a false alarm
are measured by ``studies/hidden_effect.py`` on data from which nothing is missing.
"""

from __future__ import annotations

from math import log, pi, sqrt
from typing import NamedTuple

INTERVALS = ("jacobian", "profile", "bootstrap")
"""Ways in which intervals of parameters are worked out, the usual first.

The more it takes, the less it assumes.
"""

INTERVAL = 0.95
"""Probability of an interval unless another is asked for (JCGM 100:2008, 6.3.3 and annex G)."""


class SignalLevels(NamedTuple):
    """What is made of recorded signals."""

    motion: float = 0.999
    """Probability that noise would show less than a believed motion, of all candidates."""
    negative: float = 3.0
    """Standard deviations by which a stiffness is negative beyond doubt.

    Normal noise alone exceeds them in 1 of 740
    points."""
    transient_alarm: float = 1e-5
    """Chance of taking noise for a transient.

    One that hides in the noise moves K by less than its deviation.
    """
    ruled_out: float = 1e-3
    """Chance of what is seen from noise alone, below which noise is not what it is.

    By it a first cycle like the others is left out, which costs one cycle of many.
    """


SIGNALS = SignalLevels()


class VariedLevels(NamedTuple):
    """What was set, what was held, and what only wandered."""

    amplitude_wanders: float = 0.1
    """Amplitudes (as logarithms) that move by less in a whole test are not varied.

    Rheometers hold strain to 4 %.
    """
    temperature_wanders: float = 1.0
    """Kelvin by which temperatures differ at least if they were varied or chosen.

    Ovens and chambers drift by some tenths of one.
    """
    amplitude_chosen: float = 0.2
    """Least distance of amplitudes (as logarithms) that were chosen.

    Ten levels a decade lie 26 % apart, 0.23 in
    logarithms."""
    fewest_one_way: int = 5
    """Distinct frequencies from which a condition that only rises or only falls with them moves
    with them: chosen at random, five values do so in 2 of 120 tests.
    """
    share_left: float = 0.3
    """Share of the rows that a fit must leave over for the rest to say anything.

    Three of ten have a median.
    """
    fewest_choices: int = 3
    """Rows beside the first at one frequency and temperature from which a difference between them
    was a choice: one slip of the rig makes one.
    """
    recurs: float = 1.5
    """Times that a frequency was measured on average, from which several amplitudes were set at
    each frequency. A strain that follows the frequency, as inertia makes it, recurs once.
    """


VARIED = VariedLevels()


class ScatterLevels(NamedTuple):
    """How large the noise is.

    As given, as repeats tell, or as estimated from the scatter about a fit.
    """

    fewest_to_doubt: int = 10
    """Degrees of freedom of the data's scatter below which it says nothing against given standard
    deviations: with ten its size is known to a quarter.
    """
    believed: float = 0.1
    """Relative error beyond which scatter about a model is no noise unless repeats or given
    standard deviations say so: rigs and rheometers repeat a stiffness within a few per cent.
    """
    repeats_alike: float = 0.3
    """Relative difference beyond which repeats are none of one thing.

    Three specimens of bitumen differ by 3 %.
    """
    outlying_frequency: float = 0.0002
    """Chance below which the scatter at one frequency is held to be no noise."""
    sharper: float = 0.7
    """The noise is estimated anew where the scatter about the best model is less than this share of
    the estimate.
    """


SCATTER = ScatterLevels()


class SearchLevels(NamedTuple):
    """Which grown models are fitted."""

    singles: int = 12
    """Effects refitted after the first scan."""
    beam: int = 4
    """Single effects from which a second one is sought."""
    seconds: int = 4
    """Second effects refitted for each of them, or of a law second conditions and terms."""
    together: int = 8
    """Pairs refitted that explain the residual only together."""
    look_further: float = 0.05
    """Chance of a false alarm from which on grown models are judged by what they leave.

    Ten times the verdict's.
    """
    left_over: float = 0.2
    """Chance of noise below which the best single effect may leave something, and pairs are tried.

    A pair that is
    tried in vain costs time, one that is not tried costs the answer."""
    resolved: float = 3.0
    """Points over which a narrow effect must spread at least."""
    common: float = 1.0
    """Prior weight below which an effect alone is not taken for an answer before pairs of common
    ones are tried.
    """
    suspicious: float = 0.01
    """Chance of a false alarm below which it is asked whether single points raise it."""
    tried_alone: int = 3
    """Grown models whose parameters are tried for the model alone."""
    hopeless: float = 0.5
    """Share of what the best grown model explains below which another one, after its first ten
    steps, is no rival and is not searched further. Of 60 artificial cases all verdicts and 58
    leading classes stay as they were.
    """
    better: float = 0.5
    """Gain in log-likelihood from which a fit has found another minimum."""
    near_an_end: float = 0.01
    """Distance from an end of its range, relative to it, at which a size rests there.

    A fit runs towards an end ever
    slower."""
    decisive: float = 10.0
    """Drop of the information criterion, or twice a log-likelihood, that is beyond doubt.

    Ten by Kass and Raftery (1995, doi:10.1080/01621459.1995.10476572): from it the best model tells
    the noise, an effect is accepted, and noise has another shape than "proportional to |K|": of few
    points some shape fits chance best, and structure is then seen where there is none.
    """


SEARCH = SearchLevels()


class EvidenceLevels(NamedTuple):
    """What a model's parameters cost, and prior odds."""

    credible: float = 0.93
    """A class holds at least this share of the probability of all explanations."""
    unasked: float = 0.99
    """The same of what stands in the place of an effect that a machine accepts among others."""
    one_curve: float = 0.35
    """Curves this close (root mean square, in units of the noise) are one curve for these data."""
    prior_nothing: float = 0.5
    """Chance, before the data, that nothing is missing: even odds."""
    beyond_physics: float = 0.001
    """Prior weight of an effect that is larger than any specimen makes it.

    A unit or a geometry would have to be
    wrong, as it is in one table of a thousand."""
    prior_pair: float = 0.5
    """Prior weight of a second missing effect.

    Pairs have no order, so that two against one weigh half of it.
    """
    apparatus: float = 0.1
    """Prior weight, in tests in time, of a fault of the apparatus beside what specimens do: they
    flow, yield and hang loose more often than a serviced instrument drifts, saturates or lags.
    """
    outside: float = 0.15
    """Chance, before the data, that what is missing is in no library."""
    beside: float = 0.9
    """Probability from which something is missing beside the leading effect."""
    other_shape: float = 0.3
    """Share of the probability of a narrow effect, of one needed twice, of two parts of a material,
    and of two effects beside such a part, that goes to something of another shape or origin: its
    looks are known better than what it is.
    """
    unknown_size: float = log(10.0 * log(10.0) / sqrt(2.0 * pi))
    """Cost of a size that may lie anywhere in ten decades."""
    unknown_sign: float = log(2.0)
    """Cost of a size that may be positive or negative."""
    vague: float = 10.0
    """Square of the relative width within which a parameter other than a size is known beforehand.
    """
    rivals: float = 6.0
    """Log-likelihood within which a model rivals the best one, whatever its parameters cost."""
    open: float = 0.3
    """Relative variance from which a parameter is held to be left open by the data."""
    least_influence: float = 1.0
    """Change of K over the noise, per natural unit of a parameter, below which its effect does
    without it.
    """
    least_share: float = 0.02
    """Share of its range below which a parameter is not open."""
    harmonic_tolerance: float = 0.3
    """Share by which a predicted harmonic may be off.

    Describing functions hold the displacement to be a sinusoid,
    which no rig makes it."""
    least_harmonic: float = 0.002
    """Share of the first harmonic below which a third one is held to be the rig's."""
    most_harmonic_rows: float = 10.0
    """Rows that count at most: what is wrong with a prediction is wrong in all of them."""
    unpredicted_harmonic: float = -3.0
    """Log-likelihood where an effect makes harmonics of which neither a formula nor a bound is
    known.
    """
    prior_chain: float = 0.5
    """Prior weight of each fault of a measuring chain beside that of a common effect."""
    fewest_levels: int = 3
    """Levels of a condition from which a gain of its own at each is no other name for a trend.

    And one of them can stand out from the others.
    """
    points_of_each: int = 4
    """Points of each level at least, so that the levels do not follow the noise."""
    as_good: float = 3.0
    """Log-evidence by which an explanation may be worse and count as good: odds of one to twenty.

    "Strong" by Kass and Raftery (1995, doi:10.1080/01621459.1995.10476572), who count it twice.
    """


EVIDENCE = EvidenceLevels()


class VerdictLevels(NamedTuple):
    """From evidence to a word."""

    arithmetic: float = 2e-5
    """Error that no instrument reaches: data nearer to a model were computed.

    The lines of a free spectrum follow a
    smooth one to 5e-6."""
    neighbours: float = 0.05
    """Chance that the points of an error beyond the floor lie side by side.

    Noise with long tails (Student's t, three
    degrees of freedom) has such an error in 3 of 40 data sets: it is called structure in one of
    250.
    """
    library_alarm: float = 0.006
    """Chance of a false alarm granted to the scan of the library."""
    structure_alarm: float = 0.005
    """Chance of a false alarm granted to the test for structure of any kind."""
    beyond_doubt: float = 0.002
    """Chance of a false alarm below which something is missing, however weakly it is named.

    As much is granted to the test of the repeats' scatter.
    """
    remainder: float = 0.005
    """Share of the misfit that named effects may leave and still be the verdict."""
    small_rest: float = 2.0
    """Error of the best model over the noise floor up to which what it leaves is small beside the
    noise.
    """
    noisy: float = 1.2
    """Error over noise floor below which only the pattern of a misfit tells it from noise."""
    below: float = 0.9
    """Error over an estimated noise floor below which the estimate is wrong, not the model."""
    nothing_left: float = 10.0
    """Chi-square beyond the degrees of freedom that is no misfit worth a verdict."""
    fewest_spare: int = 4
    """Degrees of freedom below which data cannot be judged."""
    enough_spare: int = 10
    """Degrees of freedom from which the evidence may rule out that nothing is missing without an
    alarm: of fewer one lucky fit does, as of a sweep of three points that a phase error follows to
    a thirtieth of its scatter.
    """
    harmonic_alarm: float = 0.01
    """Chance that any harmonic of the force is held to be real where all are noise.

    Twice that of an alarm, for the
    two tests of odd and even ones."""
    own_curves: float = 0.75
    """Share of what sets repeats apart from which a curve of each run is its cause.

    0.998 or more for specimens of
    bitumen (fhwa-ptf-binder-dsr), 0.24 to 0.51 for noise that goes on from point to point."""
    drift_share: float = 0.5
    """Share of what the curves of runs explain, from which one slow curve over all rows is its
    cause, where it leaves no more than they do: 0.54 to 1 for artificial drifts.
    """
    one_curve: float = 4.0
    """Mean square that one slow curve leaves, over that of curves of each run, up to which there
    was one drift: 1 to 2 for an artificial drift, 100 for specimens measured one after the other.
    """
    ruled_out: float = 0.02
    """Probability of "nothing" below which something is missing though no test raises its alarm.

    Of a narrow feature
    the tests, which look everywhere, see less than the evidence for one place. Of 1,023 data sets
    from which nothing is missing one has less.
    """
    likely: float = 0.5
    """Probability from which an effect of the first class is called missing."""
    clear_evidence: float = 2.0 * EVIDENCE.as_good
    """Drop of the information criterion, or twice a log-likelihood, that counts.

    From it something is missing. Of the noise as much is asked for two sizes, one of K' and one of
    K'', and for a floor of constant force: proportional noise brings it in 1 to 2 of 100 tests.
    """
    misfit: float = 1.3
    """Error over noise floor from which a fit does not hold."""
    certified: float = 0.013
    """Error below which what is missing is told to be little.

    The standard uncertainty to which NIST certifies the
    moduli of its fluid SRM 2491, at most frequencies. No rig is right to better, however little it
    scatters.
    """
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
    """Share of an error that an effect leaves at most to be named in the headline though something
    is left.
    """
    helps: float = 0.9
    """Share of an error that an effect leaves at most to be told as a help: who looks at the plot
    sees a tenth, and no less.
    """
    most_alike: int = 3
    """Effects of which one is so named at most: of more the headline would not be one."""
    mostly: float = 0.8
    """Share of a misfit, in chi-square, from which it is told as being all of one kind."""
    close_power: float = 0.35
    """A slope this near one of these powers is called by its name."""
    spread: float = 1.5
    """Largest over smallest amplitude from which a slope is worth saying."""
    agrees: float = 1.5
    """Ratio up to which two values, or errors, are said to agree."""
    sentence_alarm: float = 0.001
    """Chance of noise alone below which a sentence is said of what is left, or of one level.

    Each of a dozen of them
    may be wrong, so that it gets a fifth of the verdict's."""
    stands_out: float = 2.0
    """Error over the median of all levels from which a level is no material.

    The same rig, specimen and noise. Above
    what sound levels have (see `SuperpositionLevels.stands_out`), and below three times, as a
    chance is asked too.
    """
    accepted: float = 0.001
    """Chance of a false alarm below which an effect is accepted without asking."""
    predicts: float = 0.7
    """Error of prediction, over that of the rung before, up to which an accepted effect stays
    though the rest is unexplained.
    """
    all_of_it: float = 0.01
    """Chance of noise alone above which one curve is held to be all that is left."""
    rival_rest: float = 0.25
    """Share of what one of two rival descriptions explains that the other may explain beside it."""
    causal: float = 10.0
    """Log-evidence from which a residual is called causal, or not."""
    profiled: float = 0.1
    """Probability from which an effect's interval is worth the time of a profile.

    Nobody reads those of others.
    """
    predicts_better: float = 0.98
    """Share of an error of prediction from which on a smaller one is better."""


VERDICT = VerdictLevels()


class OutliersLevels(NamedTuple):
    """Single points that stand out."""

    rare: float = 0.0001
    """Chance of noise alone below which data are contradicted.

    The largest of all points is held to stand out, a period to be no noise, replicates to differ as
    a whole, given standard deviations to be misstated: whoever measured knew more of the rig than a
    few points tell.
    """
    most: float = 0.05
    """Share of the points that may stand out; more are no outliers but structure."""
    heavier: float = 3.0
    """Log-likelihood by which the others must speak for long tails before a point that is far off
    is held to be one.
    """
    carries: float = 0.5
    """Share of what a fit leaves from which one point is suspected of having bent it.

    Of 12 points of noise one
    carries half in 7 of 1,000 data sets, of 16 in 1 of 2,000."""
    settles: float = 0.1
    """Share of the misfit that may be left without such a point: less, and it was the point."""
    price: float = 5.0
    """Log-odds against a point being an outlier, beside the one in n for which point it is."""


OUTLIERS = OutliersLevels()


class WhereLevels(NamedTuple):
    """Places at which a model fails."""

    alarm: float = 0.003
    """Chance that noise alone makes a place of one part of K."""
    slight: float = 0.1
    """Share of the clearest place's standard deviations below which a place is not worth a sentence
    beside it.
    """
    one_period: float = 0.4
    """Share of the power beyond the noise's that lies at one period if a misfit is a ripple."""
    levels_differ: float = 0.01
    """Chance of noise alone below which levels, specimens or cycles are held to differ."""
    alike: float = 0.3
    """Share of a misfit by which it may differ between levels and be called the same."""
    close_power: float = 0.25
    """Distance of an exponent from a whole one at which it is called by it."""


WHERE = WhereLevels()


class SuperpositionLevels(NamedTuple):
    """Whether sweeps at several temperatures are one curve."""

    added: float = 0.01
    """Error that superposition may add and still be good enough.

    Specimens and loadings hardly repeat to 1 %.
    """
    stands_out: float = 3.0
    """Error of a material at one level alone, over the median of the levels, from which it is no
    material. In 15 measured series (nist-srm2491, 3m-468mp-acrylic-tts, polystyrene-three-tests,
    the lanes of fhwa-ptf-binder-dsr, two of reptate-polyisoprene-osc) sound levels have 0.35 to 1.8
    of it, those that slip, or whose repeats are of several specimens, 4.8 and more.
    """
    seen: float = 0.999
    """Probability with which a modulus that goes with the frequency does so by more than its
    scatter: of 25 flat series of 20 levels, two parts each, one has a level that is taken for a
    slope.
    """
    flat: float = 0.05
    """Share of the stiffness by which storage and loss of a flat sweep change over a decade at
    most: an error of 1 % in the modulus, to which loadings hardly repeat, then moves a shift by a
    fifth of a decade.
    """
    vertical_unknown: float = 1.0
    """Half-width of an interval of ln b from which a vertical factor says nothing about a law.

    None moves b so.
    """
    vertical_range: float = 2.0
    """Range of vertical factors beyond physics.

    Rho T changes by less than this between any common temperatures.
    """
    shared_errors: float = 0.5
    """Scatter within a sweep in units of the given standard deviations, below which these hold
    errors that its points share.
    """
    repeats_differ: float = 0.005
    """Relative scatter of repeats from which it is told.

    Below it is the usual noise of an instrument.
    """
    missed: float = 0.5
    """Share of storage or loss by which a line misses it that nobody overlooks.

    Half of it, on a logarithmic axis a
    third of a decade."""
    worth_a_place: float = 0.1
    """Share of what superposition leaves that a place must explain to be told.

    Many small ones are no answer.
    """
    branch_seen: float = 0.01
    """Share of |K| that a branch must have somewhere to be looked at.

    Less hides in what loadings differ by.
    """


SUPERPOSITION = SuperpositionLevels()


class ExperimentLevels(NamedTuple):
    """What could be measured next."""

    telling: float = 2.0
    """Separation below which a measurement is not worth its effort: the odds hardly change."""
    settled: float = 5.0
    """Separation in standard deviations that settles the matter."""
    rival: float = 0.001
    """Chance, beside that of the leading effect, from which another is worth a measurement.

    By itself too: beside nothing, or an unknown, nobody may believe in either.
    """


EXPERIMENT = ExperimentLevels()


class RepeatsLevels(NamedTuple):
    """What repeats and replicates tell."""

    enough: float = 8.0
    """Degrees of freedom, or repeated points, below which a scatter says too little of the noise.

    With eight its size is known to a quarter.
    """
    points_of_a_run: int = 6
    """Points of a run from which its own gain says little of each of them."""
    drift_odds: float = 20.0
    """Odds for one settling curve against a gain of each run from which it is a drift.

    Strong evidence (Kass and
    Raftery 1995, doi:10.1080/01621459.1995.10476572)."""


REPEATS = RepeatsLevels()


class ComparisonLevels(NamedTuple):
    """Which of many models are as good as any material, and which are one curve."""

    chance: float = 0.001
    """Chance that noise lets a free spectrum gain so much on a model that lacks nothing.

    With forty models compared,
    one right one in 25 data sets is lost."""
    alike: float = 2.0
    """Standard deviations of the noise between two curves, over all points together, below which no
    data like these tell them apart.
    """
    most_spent: float = 0.5
    """Share of the measured numbers from which a model has more parameters than it leaves numbers
    to judge them by.
    """


COMPARISON = ComparisonLevels()


class CourseLevels(NamedTuple):
    """When a specimen is held to change with time."""

    fewest_times: int = 6
    """Times from which there is a course at all.

    Of three for each degree six give a curve of the second, the
    first that shows whether a change goes on or comes to rest."""
    fewest_of_a_round: int = 5
    """Frequencies from which the rows of one round are a sweep that can be judged by itself.

    Of ten numbers a model
    of four parameters leaves more than `VerdictLevels.fewest_spare`."""
    largest_mutation: float = 0.1
    """Relative change within one period up to which a point is of one state, a tenth as where Mours
    and Winter 1994 (doi:10.1007/BF00369354) hold a test to be quasi-steady.
    """
    held_force: float = 0.2
    """Spread of the logarithm of the force over that of the amplitude, and the same of their
    scatter from point to point, below which the force was held and the amplitude followed the
    specimen: of an amplitude that was chosen the second is one or more.
    """


COURSE = CourseLevels()


class InventionLevels(NamedTuple):
    """When a law is called found, and what it costs to write it."""

    refined: int = 24
    """Candidates that are fitted in earnest, of some hundred that are scanned."""
    extended: int = 3
    """Of these so many are tried with a second condition and a second term."""
    paired: int = 60
    """Candidates of which pairs are tried that show only together."""
    pairs: int = 24
    """Such pairs that are looked at; those of two planes are no one law."""
    same: float = 0.01
    """Distance of two curves, in units of the noise, below which two formulas are one law."""
    symbol: float = 0.3
    """Cost of each part of a formula, in log-evidence.

    A grammar of 140 laws of about ten parts makes each of them cost ln(140), 5."""
    alarm: float = 0.002
    """Chance of a false alarm granted to the search for a law, all candidates together."""
    hopeless: float = 40.0
    """Log-likelihood beyond which a law is no rival, whatever the others' parameters cost."""
    known: int = 6
    """Effects with a name that are held against the likeliest law."""
    told: int = 8
    """Laws of a class that are told at most."""
    repeated: float = 0.1
    """Share of a column's spread that other columns leave, below which it only repeats them."""


INVENTION = InventionLevels()
