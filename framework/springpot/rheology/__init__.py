"""Rheology: elements, the four compositions, parameters and models."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .drawing import draw as draw
    from .drawing import drawing_of as drawing_of
    from .effect import Answered as Answered
    from .effect import (
        AppliesTo as AppliesTo,
    )
    from .effect import (
        Effect as Effect,
    )
    from .effect import (
        InstrumentConstant as InstrumentConstant,
    )
    from .effect import (
        Layer as Layer,
    )
    from .effect import StageLaw as StageLaw
    from .effect import on_clock as on_clock
    from .effect import on_loading as on_loading
    from .effect import on_response as on_response
    from .elements import Continuum as Continuum
    from .elements import (
        FixedPower as FixedPower,
    )
    from .elements import (
        basset as basset,
    )
    from .elements import (
        dashpot as dashpot,
    )
    from .elements import (
        mass as mass,
    )
    from .elements import (
        spring as spring,
    )
    from .elements import (
        springpot as springpot,
    )
    from .factors import (
        activation_energy as activation_energy,
    )
    from .factors import (
        arrhenius as arrhenius,
    )
    from .factors import (
        delay as delay,
    )
    from .factors import (
        filter_mismatch as filter_mismatch,
    )
    from .factors import (
        gain as gain,
    )
    from .factors import (
        heated as heated,
    )
    from .factors import (
        heating as heating,
    )
    from .factors import (
        steady_dashpot as steady_dashpot,
    )
    from .factors import (
        temperature_power as temperature_power,
    )
    from .factors import (
        wlf as wlf,
    )
    from .grammar import Formula as Formula
    from .hysteresis import smooth_hysteresis as smooth_hysteresis
    from .hysteresis import yielding_spring as yielding_spring
    from .intime import Traced as Traced
    from .levels import (
        HELD as HELD,
    )
    from .levels import (
        Levels as Levels,
    )
    from .levels import Own as Own
    from .levels import (
        free_factors as free_factors,
    )
    from .levels import (
        free_vertical_factors as free_vertical_factors,
    )
    from .levels import (
        levels_of as levels_of,
    )
    from .model import Model as Model
    from .nodes import (
        FULL as FULL,
    )
    from .nodes import (
        GRADIENT as GRADIENT,
    )
    from .nodes import (
        VALUE as VALUE,
    )
    from .nodes import (
        Mapped as Mapped,
    )
    from .nodes import (
        Node as Node,
    )
    from .nodes import (
        Response as Response,
    )
    from .nodes import (
        chain as chain,
    )
    from .nodes import (
        fixed_side_wave as fixed_side_wave,
    )
    from .nodes import (
        moving_side_wave as moving_side_wave,
    )
    from .nodes import (
        parallel as parallel,
    )
    from .nodes import (
        series as series,
    )
    from .nodes import (
        shift as shift,
    )
    from .nonlinear import (
        balanced_series as balanced_series,
    )
    from .nonlinear import (
        coulomb_friction as coulomb_friction,
    )
    from .nonlinear import (
        crosstalk_force as crosstalk_force,
    )
    from .nonlinear import (
        cubic_dashpot as cubic_dashpot,
    )
    from .nonlinear import (
        cubic_spring as cubic_spring,
    )
    from .nonlinear import (
        elasto_sliding as elasto_sliding,
    )
    from .nonlinear import (
        gapped_spring as gapped_spring,
    )
    from .nonlinear import (
        payne_softening as payne_softening,
    )
    from .nonlinear import (
        power_law_damper as power_law_damper,
    )
    from .nonlinear import (
        slip_film as slip_film,
    )
    from .parameters import (
        AMPLITUDE as AMPLITUDE,
    )
    from .parameters import (
        FORCE as FORCE,
    )
    from .parameters import KELVIN_FORM as KELVIN_FORM
    from .parameters import MAXWELL_FORM as MAXWELL_FORM
    from .parameters import (
        PURE as PURE,
    )
    from .parameters import (
        RADIAN_PER_SECOND as RADIAN_PER_SECOND,
    )
    from .parameters import (
        SECOND as SECOND,
    )
    from .parameters import (
        STIFFNESS as STIFFNESS,
    )
    from .parameters import TIME_FORM as TIME_FORM
    from .parameters import (
        VISCOSITY as VISCOSITY,
    )
    from .parameters import (
        Dimension as Dimension,
    )
    from .parameters import (
        Parameter as Parameter,
    )
    from .parameters import SearchForm as SearchForm
    from .parameters import columns as columns
    from .parameters import limits_form as limits_form
    from .parameters import (
        order as order,
    )
    from .parameters import (
        quasi_property as quasi_property,
    )
    from .parameters import (
        relaxation_time as relaxation_time,
    )
    from .parameters import rows as rows
    from .parameters import (
        stiffness as stiffness,
    )
    from .parameters import (
        viscosity as viscosity,
    )
    from .points import (
        KELVIN as KELVIN,
    )
    from .points import (
        Complex as Complex,
    )
    from .points import (
        Points as Points,
    )
    from .points import (
        Real as Real,
    )
    from .points import (
        power_of_s as power_of_s,
    )
    from .spectrum import Spectrum as Spectrum
    from .typed import law as law

__getattr__, __dir__ = offered(
    __name__,
    {
        "drawing": "draw drawing_of",
        "effect": (
            "Answered AppliesTo Effect InstrumentConstant Layer on_clock on_loading on_response "
            "StageLaw"
        ),
        "elements": "basset Continuum dashpot FixedPower mass spring springpot",
        "grammar": "Formula",
        "hysteresis": "smooth_hysteresis yielding_spring",
        "intime": "Traced",
        "levels": "free_factors free_vertical_factors HELD Levels levels_of Own",
        "model": "Model",
        "nodes": (
            "chain fixed_side_wave FULL GRADIENT Mapped moving_side_wave Node parallel Response "
            "series shift VALUE"
        ),
        "nonlinear": (
            "balanced_series coulomb_friction crosstalk_force cubic_dashpot "
            "cubic_spring elasto_sliding gapped_spring "
            "payne_softening power_law_damper slip_film"
        ),
        "parameters": (
            "AMPLITUDE columns Dimension FORCE KELVIN_FORM limits_form MAXWELL_FORM order "
            "Parameter PURE quasi_property RADIAN_PER_SECOND relaxation_time rows SearchForm "
            "SECOND STIFFNESS stiffness TIME_FORM VISCOSITY viscosity"
        ),
        "points": "Complex KELVIN Points power_of_s Real",
        "spectrum": "Spectrum",
        "factors": (
            "activation_energy arrhenius delay filter_mismatch gain heated heating "
            "steady_dashpot temperature_power wlf"
        ),
        "typed": "law",
    },
)
