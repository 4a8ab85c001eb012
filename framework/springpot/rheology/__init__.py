"""Rheology: elements, the four compositions, parameters and models."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .drawing import draw as draw, drawing_of as drawing_of
    from .effect import (
        Answered as Answered,
        AppliesTo as AppliesTo,
        Effect as Effect,
        InstrumentConstant as InstrumentConstant,
        Layer as Layer,
        StageLaw as StageLaw,
        on_clock as on_clock,
        on_loading as on_loading,
        on_response as on_response,
    )
    from .elements import (
        Continuum as Continuum,
        FixedPower as FixedPower,
        basset as basset,
        dashpot as dashpot,
        mass as mass,
        spring as spring,
        springpot as springpot,
    )
    from .factors import (
        activation_energy as activation_energy,
        arrhenius as arrhenius,
        delay as delay,
        filter_mismatch as filter_mismatch,
        gain as gain,
        heated as heated,
        heating as heating,
        steady_dashpot as steady_dashpot,
        temperature_power as temperature_power,
        wlf as wlf,
    )
    from .grammar import Formula as Formula
    from .hysteresis import (
        smooth_hysteresis as smooth_hysteresis,
        yielding_spring as yielding_spring,
    )
    from .intime import Traced as Traced
    from .levels import (
        Levels as Levels,
        Own as Own,
        free_factors as free_factors,
        free_vertical_factors as free_vertical_factors,
        levels_of as levels_of,
    )
    from .model import Model as Model
    from .nodes import (
        FULL as FULL,
        GRADIENT as GRADIENT,
        VALUE as VALUE,
        Mapped as Mapped,
        Node as Node,
        Response as Response,
        chain as chain,
        fixed_side_wave as fixed_side_wave,
        moving_side_wave as moving_side_wave,
        parallel as parallel,
        series as series,
        shift as shift,
    )
    from .nonlinear import (
        balanced_series as balanced_series,
        coulomb_friction as coulomb_friction,
        crosstalk_force as crosstalk_force,
        cubic_dashpot as cubic_dashpot,
        cubic_spring as cubic_spring,
        elasto_sliding as elasto_sliding,
        gapped_spring as gapped_spring,
        payne_softening as payne_softening,
        power_law_damper as power_law_damper,
        slip_film as slip_film,
    )
    from .parameters import (
        AMPLITUDE as AMPLITUDE,
        FORCE as FORCE,
        KELVIN_FORM as KELVIN_FORM,
        MAXWELL_FORM as MAXWELL_FORM,
        PURE as PURE,
        RADIAN_PER_SECOND as RADIAN_PER_SECOND,
        SECOND as SECOND,
        STIFFNESS as STIFFNESS,
        TIME_FORM as TIME_FORM,
        VISCOSITY as VISCOSITY,
        Dimension as Dimension,
        Parameter as Parameter,
        SearchForm as SearchForm,
        columns as columns,
        limits_form as limits_form,
        order as order,
        quasi_property as quasi_property,
        relaxation_time as relaxation_time,
        rows as rows,
        stiffness as stiffness,
        viscosity as viscosity,
    )
    from .points import (
        HELD as HELD,
        KELVIN as KELVIN,
        Complex as Complex,
        Points as Points,
        Real as Real,
        power_of_s as power_of_s,
    )
    from .spectrum import Spectrum as Spectrum
    from .typed import law as law

__getattr__, __dir__ = offered(__name__)
