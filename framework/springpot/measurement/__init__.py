"""Measurement: dynamic test data and their units, time signals, noise, geometries."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from springpot.files import (
        MOST_CELLS as MOST_CELLS,
    )
    from springpot.files import (
        MOST_COLUMNS as MOST_COLUMNS,
    )
    from springpot.files import (
        MOST_TABLES as MOST_TABLES,
    )
    from springpot.files import (
        Budget as Budget,
    )
    from springpot.files import (
        budget_of as budget_of,
    )
    from springpot.files import (
        bytes_of as bytes_of,
    )
    from springpot.files import (
        json_of as json_of,
    )
    from springpot.files import (
        toml_of as toml_of,
    )
    from springpot.files import (
        within_budget as within_budget,
    )
    from springpot.writing import (
        guarded as guarded,
    )
    from springpot.writing import (
        guarded_line as guarded_line,
    )
    from springpot.writing import (
        unguarded as unguarded,
    )
    from springpot.writing import (
        unguarded_line as unguarded_line,
    )

    from . import geometry as geometry
    from .conversion import (
        as_modulus as as_modulus,
    )
    from .conversion import (
        as_stiffness as as_stiffness,
    )
    from .conversion import joined as joined
    from .conversion import (
        through as through,
    )
    from .followed import Record as Record
    from .from_signals import measurement_from_signals as measurement_from_signals
    from .geometry import parse_geometry as parse_geometry
    from .imposed import Loading as Loading
    from .independence import (
        independent as independent,
    )
    from .independence import (
        spread_of as spread_of,
    )
    from .independence import (
        steadied as steadied,
    )
    from .measurement import Measurement as Measurement
    from .measurement import misspelt as misspelt
    from .mixed_tests import (
        settings_of as settings_of,
    )
    from .mixed_tests import (
        sweeps_of as sweeps_of,
    )
    from .mixed_tests import (
        tests_together as tests_together,
    )
    from .opening import (
        PROMISED as PROMISED,
    )
    from .opening import (
        DataSet as DataSet,
    )
    from .opening import Measured as Measured
    from .opening import Suite as Suite
    from .opening import TimeReader as TimeReader
    from .opening import (
        open_measurement as open_measurement,
    )
    from .opening import (
        parts_of as parts_of,
    )
    from .opening import (
        pick_reader as pick_reader,
    )
    from .opening import (
        select as select,
    )
    from .opening import (
        without as without,
    )
    from .other_test import OtherTest as OtherTest
    from .reader import (
        Choice as Choice,
    )
    from .reader import (
        OpenQuestion as OpenQuestion,
    )
    from .reader import (
        Part as Part,
    )
    from .reader import (
        Question as Question,
    )
    from .reader import (
        Reader as Reader,
    )
    from .reader import (
        parts_as_opened as parts_as_opened,
    )
    from .replicates import average_repeats as average_repeats
    from .replicates import thinned as thinned
    from .scatter import at_least_rounding as at_least_rounding
    from .scatter import with_noise as with_noise
    from .signals import Signals as Signals
    from .signals import harmonics_of as harmonics_of
    from .timenoise import noise_of as noise_of
    from .timetest import TimeTest as TimeTest
    from .units import (
        AMPLITUDE_UNITS as AMPLITUDE_UNITS,
    )
    from .units import (
        ANGLE_UNITS as ANGLE_UNITS,
    )
    from .units import (
        FILE_UNITS as FILE_UNITS,
    )
    from .units import (
        FORCE_UNITS as FORCE_UNITS,
    )
    from .units import (
        FREQUENCY_UNITS as FREQUENCY_UNITS,
    )
    from .units import (
        LENGTH_UNITS as LENGTH_UNITS,
    )
    from .units import (
        MODULUS_UNITS as MODULUS_UNITS,
    )
    from .units import (
        PRESSURE_UNITS as PRESSURE_UNITS,
    )
    from .units import (
        STIFFNESS_UNITS as STIFFNESS_UNITS,
    )
    from .units import (
        STRAIN_UNITS as STRAIN_UNITS,
    )
    from .units import (
        TEMPERATURE_UNITS as TEMPERATURE_UNITS,
    )
    from .units import (
        TIME_UNITS as TIME_UNITS,
    )
    from .units import (
        TORQUE_UNITS as TORQUE_UNITS,
    )
    from .units import (
        Units as Units,
    )
    from .units import (
        known_unit as known_unit,
    )
    from .units import (
        near_units as near_units,
    )
    from .units import (
        normal_unit as normal_unit,
    )
    from .units import (
        temperature_in_celsius as temperature_in_celsius,
    )

__getattr__, __dir__ = offered(
    __name__,
    {
        "springpot.writing": "guarded guarded_line unguarded unguarded_line",
        "followed": "Record",
        "from_signals": "measurement_from_signals",
        "geometry": "geometry parse_geometry",
        "imposed": "Loading",
        "independence": "independent spread_of steadied",
        "conversion": "as_modulus as_stiffness joined through",
        "measurement": "Measurement misspelt",
        "mixed_tests": "settings_of sweeps_of tests_together",
        "opening": (
            "DataSet Measured open_measurement parts_of pick_reader PROMISED select Suite"
            " TimeReader without"
        ),
        "other_test": "OtherTest",
        "reader": "Choice OpenQuestion Part parts_as_opened Question Reader",
        "replicates": "average_repeats thinned",
        "scatter": "at_least_rounding with_noise",
        "signals": "harmonics_of Signals",
        "springpot.files": (
            "Budget budget_of bytes_of json_of MOST_CELLS MOST_COLUMNS MOST_TABLES toml_of "
            "within_budget"
        ),
        "timenoise": "noise_of",
        "timetest": "TimeTest",
        "units": (
            "AMPLITUDE_UNITS ANGLE_UNITS FILE_UNITS FORCE_UNITS FREQUENCY_UNITS known_unit "
            "LENGTH_UNITS "
            "MODULUS_UNITS near_units normal_unit PRESSURE_UNITS STIFFNESS_UNITS STRAIN_UNITS "
            "temperature_in_celsius TEMPERATURE_UNITS TIME_UNITS TORQUE_UNITS Units"
        ),
    },
)
