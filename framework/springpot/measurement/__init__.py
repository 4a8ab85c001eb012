"""Measurement: dynamic test data and their units, time signals, noise, geometries."""

from springpot.inputs import bytes_of, json_of, toml_of
from springpot.rheology import HELD, KELVIN

from . import geometry
from .budget import MOST_CELLS, MOST_COLUMNS, MOST_TABLES, Budget, budget_of, within_budget
from .catalogue import DataSet
from .cells import guarded, guarded_line, unguarded, unguarded_line
from .covered import RATE, Covered
from .from_signals import OneTest, measurement_from_signals, measurement_of_tests
from .geometry import Geometry
from .geometry_text import parse_geometry
from .imposed import Loading
from .independence import Spread, independent, moved_along, spread_of, steadied, telling
from .interface import as_modulus, as_stiffness, through
from .joining import FILE, joined
from .measurement import CONDITIONS, Measurement, misspelt, points_at
from .moduli import Moduli
from .noise import with_noise
from .one_frequency import (
    HELD_ALIKE,
    at_one_frequency,
    distinct_log_omega,
    frequency_numbers,
    held_frequency_numbers,
    rounded_log_omega,
)
from .opening import open_measurement, parts_of, pick_reader
from .question import OpenQuestion, Question
from .reader import Choice, Part, Reader, parts_as_opened
from .replicates import Averaged, average_repeats, noise_of_repeats, thinned
from .scatter import (
    LEAST_RELATIVE,
    Noise,
    Scatter,
    at_least_rounding,
    checked_noise,
    noise_shape,
    plausible_variance,
    robust_noise_shape,
    rounding_step,
)
from .selection import conditions, select, without
from .signals import Harmonics, Signals, harmonics_of
from .sweeps import Sweep, sweeps_of, temperatures_differ
from .timed import Timed, grown, material_of
from .timeeffect import Answered, Record, Stage, TimeEffect
from .timenoise import SignalNoise, noise_of, relative_scatter
from .timereader import TimeReader, open_in_time
from .timetest import TimeTest
from .together import TIME, largest_test, settings_of, tests_together
from .units import (
    AMPLITUDE_UNITS,
    ANGLE_UNITS,
    FORCE_UNITS,
    FREQUENCY_UNITS,
    LENGTH_UNITS,
    MODULUS_UNITS,
    PRESSURE_UNITS,
    STIFFNESS_UNITS,
    STRAIN_UNITS,
    TEMPERATURE_UNITS,
    TIME_UNITS,
    TORQUE_UNITS,
    Units,
    known_unit,
    near_units,
    normal_unit,
    one_modulus,
    temperature_in_celsius,
)

__all__ = [
    "RATE",
    "Covered",
    "Sweep",
    "distinct_log_omega",
    "frequency_numbers",
    "at_one_frequency",
    "held_frequency_numbers",
    "rounded_log_omega",
    "TIME",
    "sweeps_of",
    "temperatures_differ",
    "AMPLITUDE_UNITS",
    "Averaged",
    "ANGLE_UNITS",
    "Budget",
    "CONDITIONS",
    "FILE",
    "HELD",
    "HELD_ALIKE",
    "Choice",
    "DataSet",
    "FORCE_UNITS",
    "FREQUENCY_UNITS",
    "Geometry",
    "Harmonics",
    "KELVIN",
    "LEAST_RELATIVE",
    "LENGTH_UNITS",
    "Loading",
    "MODULUS_UNITS",
    "MOST_CELLS",
    "MOST_COLUMNS",
    "MOST_TABLES",
    "Measurement",
    "Moduli",
    "Noise",
    "OneTest",
    "OpenQuestion",
    "PRESSURE_UNITS",
    "Part",
    "Question",
    "Reader",
    "STIFFNESS_UNITS",
    "Scatter",
    "STRAIN_UNITS",
    "SignalNoise",
    "Signals",
    "Spread",
    "TEMPERATURE_UNITS",
    "TIME_UNITS",
    "Answered",
    "Record",
    "Stage",
    "TimeEffect",
    "Timed",
    "grown",
    "material_of",
    "TORQUE_UNITS",
    "TimeReader",
    "TimeTest",
    "Units",
    "as_modulus",
    "as_stiffness",
    "at_least_rounding",
    "average_repeats",
    "budget_of",
    "bytes_of",
    "checked_noise",
    "conditions",
    "geometry",
    "guarded",
    "guarded_line",
    "harmonics_of",
    "independent",
    "joined",
    "json_of",
    "known_unit",
    "largest_test",
    "measurement_from_signals",
    "measurement_of_tests",
    "misspelt",
    "near_units",
    "moved_along",
    "normal_unit",
    "one_modulus",
    "noise_of",
    "noise_of_repeats",
    "noise_shape",
    "open_measurement",
    "parse_geometry",
    "parts_as_opened",
    "parts_of",
    "pick_reader",
    "plausible_variance",
    "points_at",
    "relative_scatter",
    "robust_noise_shape",
    "rounding_step",
    "select",
    "settings_of",
    "spread_of",
    "steadied",
    "telling",
    "tests_together",
    "temperature_in_celsius",
    "open_in_time",
    "thinned",
    "through",
    "toml_of",
    "unguarded",
    "unguarded_line",
    "with_noise",
    "within_budget",
    "without",
]
