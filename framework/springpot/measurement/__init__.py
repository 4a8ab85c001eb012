"""Measurement: dynamic test data and their units, time signals, noise, geometries."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from springpot.files import (
        MOST_CELLS as MOST_CELLS,
        MOST_COLUMNS as MOST_COLUMNS,
        MOST_TABLES as MOST_TABLES,
        Budget as Budget,
        budget_of as budget_of,
        bytes_of as bytes_of,
        json_of as json_of,
        toml_of as toml_of,
        within_budget as within_budget,
    )
    from springpot.writing import (
        guarded as guarded,
        guarded_line as guarded_line,
        unguarded as unguarded,
        unguarded_line as unguarded_line,
    )

    from . import geometry as geometry
    from .conversion import (
        as_modulus as as_modulus,
        as_stiffness as as_stiffness,
        joined as joined,
        through as through,
    )
    from .covered import OtherTest as OtherTest
    from .from_signals import measurement_from_signals as measurement_from_signals
    from .geometry import parse_geometry as parse_geometry
    from .imposed import Loading as Loading
    from .independence import (
        independent as independent,
        spread_of as spread_of,
        steadied as steadied,
    )
    from .measurement import Measurement as Measurement, misspelt as misspelt
    from .mixed_up import (
        settings_of as settings_of,
        sweeps_of as sweeps_of,
        tests_together as tests_together,
    )
    from .opening import (
        PROMISED as PROMISED,
        DataSet as DataSet,
        Measured as Measured,
        Suite as Suite,
        TimeReader as TimeReader,
        open_measurement as open_measurement,
        parts_of as parts_of,
        pick_reader as pick_reader,
        select as select,
        without as without,
    )
    from .reader import (
        Choice as Choice,
        OpenQuestion as OpenQuestion,
        Part as Part,
        Question as Question,
        Reader as Reader,
        parts_as_opened as parts_as_opened,
    )
    from .recording import Record as Record
    from .replicates import average_repeats as average_repeats, thinned as thinned
    from .scatter import (
        COHERENCE as COHERENCE,
        at_least_rounding as at_least_rounding,
        with_noise as with_noise,
    )
    from .signals import Signals as Signals, harmonics_of as harmonics_of
    from .timenoise import noise_of as noise_of
    from .timetest import TimeTest as TimeTest
    from .units import (
        AMPLITUDE_UNITS as AMPLITUDE_UNITS,
        ANGLE_UNITS as ANGLE_UNITS,
        FILE_UNITS as FILE_UNITS,
        FORCE_UNITS as FORCE_UNITS,
        FREQUENCY_UNITS as FREQUENCY_UNITS,
        LENGTH_UNITS as LENGTH_UNITS,
        MODULUS_UNITS as MODULUS_UNITS,
        PRESSURE_UNITS as PRESSURE_UNITS,
        STIFFNESS_UNITS as STIFFNESS_UNITS,
        STRAIN_UNITS as STRAIN_UNITS,
        TEMPERATURE_UNITS as TEMPERATURE_UNITS,
        TIME_UNITS as TIME_UNITS,
        TORQUE_UNITS as TORQUE_UNITS,
        Units as Units,
        known_unit as known_unit,
        near_units as near_units,
        normal_unit as normal_unit,
        temperature_in_celsius as temperature_in_celsius,
    )

__getattr__, __dir__ = offered(__name__)
