"""A Functional Mock-up Unit (FMI 2.0).

Displacement in, force out, for model exchange and co-simulation.

Its source is one C file without any header from elsewhere, in the unit for whoever has another
machine, and compiled for this one where there is a C compiler. The state of a branch is the way of
its dashpot, z' = (x - z) / tau, so that the force K_e x + sum of w (x - z) follows the displacement
at once and no velocity is needed. In co-simulation a master gives the displacement at the beginning
of a step, and the force lags by that step where it gives nothing else. With the displacement's
derivative (``canInterpolateInputs``) there is no lag: the unit is exact for straight lines.
"""

from __future__ import annotations

import hashlib
import platform
import shutil
import subprocess
import zipfile
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

from springpot.solvers import Handoff, Writer

PLATFORMS = {("Linux", "x86_64"): ("linux64", ".so"), ("Darwin", "x86_64"): ("darwin64", ".dylib")}
"""Folders of FMI 2.0 for machines on which ``cc -shared`` gives what they need."""

SOURCE = r"""
/* @HEADING@ */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define N @COUNT@
#define EXPORT __attribute__((visibility("default")))
static const double W[N + 1] = {@WEIGHTS@0};
static const double TAU[N + 1] = {@TIMES@1};
static const double KE = @EQUILIBRIUM@;
/* value references: displacement, force, its rate of input, states from Z on, then rates */
enum { X, F, V, Z };

typedef struct { double x, v, t, z[N + 1]; } Unit;

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const *names) { return 0; }
EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid, const char *where,
                             const void *calls, int visible, int logging)
{ return calloc(1, sizeof(Unit)); }
EXPORT void fmi2FreeInstance(void *c) { free(c); }
EXPORT int fmi2SetupExperiment(void *c, int d, double tol, double start, int s, double stop)
{ ((Unit *)c)->t = start; return 0; }
EXPORT int fmi2EnterInitializationMode(void *c) { return 0; }
/* At rest in the displacement that it begins with. */
EXPORT int fmi2ExitInitializationMode(void *c)
{ Unit *u = c; for (int i = 0; i < N; i++) u->z[i] = u->x; return 0; }
EXPORT int fmi2Terminate(void *c) { return 0; }
EXPORT int fmi2Reset(void *c) { memset(c, 0, sizeof(Unit)); return 0; }

static double force(const Unit *u)
{ double f = KE * u->x; for (int i = 0; i < N; i++) f += W[i] * (u->x - u->z[i]); return f; }
static double rate(const Unit *u, int i) { return (u->x - u->z[i]) / TAU[i]; }

EXPORT int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *value)
{
    Unit *u = c;
    for (size_t k = 0; k < n; k++) {
        unsigned r = vr[k];
        if (r == X) value[k] = u->x;
        else if (r == F) value[k] = force(u);
        else if (r >= Z && r < Z + N) value[k] = u->z[r - Z];
        else if (r >= Z + N && r < Z + 2 * N) value[k] = rate(u, (int)(r - Z - N));
        else return 3;
    }
    return 0;
}
EXPORT int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *value)
{
    Unit *u = c;
    for (size_t k = 0; k < n; k++) {
        if (vr[k] == X) { u->x = value[k]; u->v = 0; }
        else if (vr[k] >= Z && vr[k] < Z + N) u->z[vr[k] - Z] = value[k];
        else return 3;
    }
    return 0;
}
EXPORT int fmi2GetInteger(void *c, const unsigned *vr, size_t n, int *value)
{ return n ? 3 : 0; }
EXPORT int fmi2SetInteger(void *c, const unsigned *vr, size_t n, const int *value)
{ return n ? 3 : 0; }
EXPORT int fmi2GetBoolean(void *c, const unsigned *vr, size_t n, int *value)
{ return n ? 3 : 0; }
EXPORT int fmi2SetBoolean(void *c, const unsigned *vr, size_t n, const int *value)
{ return n ? 3 : 0; }
EXPORT int fmi2GetString(void *c, const unsigned *vr, size_t n, const char **value)
{ return n ? 3 : 0; }
EXPORT int fmi2SetString(void *c, const unsigned *vr, size_t n, const char *const *value)
{ return n ? 3 : 0; }
EXPORT int fmi2GetFMUstate(void *c, void **state) { return 3; }
EXPORT int fmi2SetFMUstate(void *c, void *state) { return 3; }
EXPORT int fmi2FreeFMUstate(void *c, void **state) { return 3; }
EXPORT int fmi2SerializedFMUstateSize(void *c, void *state, size_t *n) { return 3; }
EXPORT int fmi2SerializeFMUstate(void *c, void *state, char *bytes, size_t n) { return 3; }
EXPORT int fmi2DeSerializeFMUstate(void *c, const char *bytes, size_t n, void **state) { return 3; }
EXPORT int fmi2GetDirectionalDerivative(void *c, const unsigned *z, size_t nz, const unsigned *v,
                                        size_t nv, const double *dv, double *dz) { return 3; }

/* model exchange */
EXPORT int fmi2EnterEventMode(void *c) { return 0; }
typedef struct { int again, terminate, nominals, values, defined; double next; } Event;
EXPORT int fmi2NewDiscreteStates(void *c, Event *e) { memset(e, 0, sizeof(Event)); return 0; }
EXPORT int fmi2EnterContinuousTimeMode(void *c) { return 0; }
EXPORT int fmi2CompletedIntegratorStep(void *c, int no_set, int *enter, int *terminate)
{ *enter = 0; *terminate = 0; return 0; }
EXPORT int fmi2SetTime(void *c, double t) { ((Unit *)c)->t = t; return 0; }
EXPORT int fmi2SetContinuousStates(void *c, const double *z, size_t n)
{ Unit *u = c; for (size_t i = 0; i < n && i < N; i++) u->z[i] = z[i]; return 0; }
EXPORT int fmi2GetContinuousStates(void *c, double *z, size_t n)
{ Unit *u = c; for (size_t i = 0; i < n && i < N; i++) z[i] = u->z[i]; return 0; }
EXPORT int fmi2GetDerivatives(void *c, double *d, size_t n)
{ Unit *u = c; for (size_t i = 0; i < n && i < N; i++) d[i] = rate(u, (int)i); return 0; }
EXPORT int fmi2GetEventIndicators(void *c, double *e, size_t n) { return 0; }
/* of a damper in m; solvers scale tolerances by it */
EXPORT int fmi2GetNominalsOfContinuousStates(void *c, double *x, size_t n)
{ for (size_t i = 0; i < n; i++) x[i] = 1e-3; return 0; }

/* co-simulation: exact where the displacement is straight within the step */
EXPORT int fmi2SetRealInputDerivatives(void *c, const unsigned *vr, size_t n, const int *order,
                                       const double *value)
{
    Unit *u = c;
    for (size_t k = 0; k < n; k++) { if (vr[k] != X || order[k] != 1) return 3; u->v = value[k]; }
    return 0;
}
EXPORT int fmi2GetRealOutputDerivatives(void *c, const unsigned *vr, size_t n, const int *order,
                                        double *value)
{ return 3; }
EXPORT int fmi2DoStep(void *c, double t, double h, int keep)
{
    Unit *u = c;
    for (int i = 0; i < N; i++) {
        double y = h / TAU[i];
        /* way behind: d' = v - d / tau */
        double behind = (u->x - u->z[i]) * exp(-y) - u->v * TAU[i] * expm1(-y);
        u->z[i] = u->x + u->v * h - behind;
    }
    u->x += u->v * h;
    u->t = t + h;
    return 0;
}
EXPORT int fmi2CancelStep(void *c) { return 3; }
EXPORT int fmi2GetStatus(void *c, int kind, int *value) { return 1; }
EXPORT int fmi2GetRealStatus(void *c, int kind, double *value) { return 1; }
EXPORT int fmi2GetIntegerStatus(void *c, int kind, int *value) { return 1; }
EXPORT int fmi2GetBooleanStatus(void *c, int kind, int *value) { return 1; }
EXPORT int fmi2GetStringStatus(void *c, int kind, const char **value) { return 1; }
"""


def source_of(handoff: Handoff) -> str:
    """The C file."""
    prony = handoff.prony
    # A file's name must not end the comment that it stands in.
    heading = "\n   ".join(handoff.heading()).replace("*/", "* /")
    filled = {
        "HEADING": heading,
        "COUNT": str(len(prony.times)),
        "WEIGHTS": "".join(f"{float(weight)!r}, " for weight in prony.weights),
        "TIMES": "".join(f"{float(time)!r}, " for time in prony.times),
        "EQUILIBRIUM": repr(float(prony.equilibrium)),
    }
    text = SOURCE
    for key, value in filled.items():
        text = text.replace(f"@{key}@", value)
    return text.lstrip()


def _variables(count: int) -> list[str]:
    """Elements of displacement, force, the states of so many branches and their rates."""
    channels = [
        '<ScalarVariable name="x" valueReference="0" causality="input" variability="continuous"'
        ' description="displacement"><Real start="0"/></ScalarVariable>',
        '<ScalarVariable name="F" valueReference="1" causality="output" variability="continuous"'
        ' description="force"><Real/></ScalarVariable>',
    ]
    states = [
        f'<ScalarVariable name="z[{i + 1}]" valueReference="{3 + i}" causality="local"'
        ' variability="continuous" initial="calculated"'
        ' description="way of a dashpot"><Real/></ScalarVariable>'
        for i in range(count)
    ]
    rates = [
        f'<ScalarVariable name="der(z[{i + 1}])" valueReference="{3 + count + i}"'
        ' causality="local" variability="continuous">'
        f'<Real derivative="{3 + i}"/></ScalarVariable>'
        for i in range(count)
    ]
    return [*channels, *states, *rates]


def description_of(handoff: Handoff) -> str:
    """modelDescription.xml."""
    # It brings all that opens addresses on the network along: most commands write no such file.
    from xml.sax.saxutils import quoteattr

    count = len(handoff.prony.times)
    name = quoteattr(handoff.name)
    # It tells which description belongs to which library (FMI 2.0); the same model has the same.
    guid = hashlib.sha256(source_of(handoff).encode()).hexdigest()[:32]
    files = '<SourceFiles><File name="unit.c"/></SourceFiles>'
    # Variables are counted from one here: x and F come first. Their value references in the source
    # are the same from Z on.
    states, rates = range(3, 3 + count), range(3 + count, 3 + 2 * count)
    needs = " ".join(map(str, [1, *states]))
    derivatives = "".join(
        f'<Unknown index="{rate}" dependencies="1 {state}"/>'
        for rate, state in zip(rates, states, strict=True)
    )
    if count:
        # The schema takes no empty list.
        derivatives = f"<Derivatives>{derivatives}</Derivatives>"
    initial = "".join(f'<Unknown index="{i}" dependencies="1"/>' for i in (2, *states, *rates))
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            (
                f'<fmiModelDescription fmiVersion="2.0" modelName={name} guid="{guid}"'
                ' generationTool="springpot"'
            ),
            (
                f"  description={quoteattr(' | '.join(handoff.heading()))}"
                ' numberOfEventIndicators="0">'
            ),
            f'<ModelExchange modelIdentifier="unit">{files}</ModelExchange>',
            (
                '<CoSimulation modelIdentifier="unit"'
                ' canHandleVariableCommunicationStepSize="true"'
                f' canInterpolateInputs="true">{files}</CoSimulation>'
            ),
            "<ModelVariables>",
            *_variables(count),
            "</ModelVariables>",
            (
                f'<ModelStructure><Outputs><Unknown index="2" dependencies="{needs}"/></Outputs>'
                f"{derivatives}<InitialUnknowns>{initial}</InitialUnknowns></ModelStructure>"
            ),
            "</fmiModelDescription>",
        ]
    )


def compiled(source: str) -> tuple[str, bytes] | None:
    """Name within the unit and bytes of the library for this machine; None if it cannot be made."""
    place = PLATFORMS.get((platform.system(), platform.machine()))
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if place is None or compiler is None:
        return None
    folder, suffix = place
    with TemporaryDirectory() as room:
        code, library = Path(room) / "unit.c", Path(room) / f"unit{suffix}"
        code.write_text(source, encoding="utf-8")
        command = [
            compiler,
            "-O2",
            "-w",
            "-shared",
            "-fPIC",
            "-fvisibility=hidden",
            str(code),
            "-o",
            str(library),
            "-lm",
        ]
        done = subprocess.run(command, capture_output=True, timeout=60, check=False)
        if done.returncode != 0:
            # The unit still has its source, which a master may compile itself.
            return None
        return f"binaries/{folder}/unit{suffix}", library.read_bytes()


def to_fmu(handoff: Handoff) -> bytes:
    """The archive."""
    source = source_of(handoff)
    whole = BytesIO()
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as archive:

        def put(name: str, data: bytes) -> None:
            # Without the date of this run: the same model gives the same bytes.
            archive.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)

        put("modelDescription.xml", description_of(handoff).encode())
        put("sources/unit.c", source.encode())
        library = compiled(source)
        if library is not None:
            put(*library)
    return whole.getvalue()


WRITER = Writer(
    "fmu",
    source_of,
    "FMI 2.0 unit, displacement in and force out, with its C source; compiled where there is a"
    " compiler",
    ".fmu",
    dashpot=False,
    data=to_fmu,
)
