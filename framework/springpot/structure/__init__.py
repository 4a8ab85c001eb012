"""A structure with identified dampers.

Modes, steady state, motion under a record, energy, and how sure all is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .damper import (
        Damper as Damper,
    )
    from .frame import (
        Frame as Frame,
        modes_of as modes_of,
        steady_of as steady_of,
        steady_state as steady_state,
    )
    from .motion import (
        GroundMotion as GroundMotion,
        artificial as artificial,
        motion_of as motion_of,
        simulate as simulate,
    )

__getattr__, __dir__ = offered(__name__)
