"""Files of other people's repositories: what a first diagnosis says, beside what is true of them.

Question: does a first diagnosis, without a model and without options, say what is true of files
that other people made? Measure: a rule that calls each answer right, defensible, hedged or
confidently wrong. What would answer it: 85 % right or defensible, and none confidently wrong.

Each is diagnosed without a model and without options, by its name and the hint that is printed
where its columns have no names. What is true is told by its repository: a column of the table.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import springpot
from paper.asking import asking
from springpot.benchmark import Table
from springpot.errors import SpringpotError
from springpot.files import write_text
from springpot.report.page import Entry

from .sets import COMPLETE
from .without_model import counted

UNSEEN = Path(__file__).resolve().parents[3] / "shared" / "unseen"
ANSWERS = Path("answers") / "unseen.json"
COLUMNS = (
    *("file", "verdict", "first names", "error before [%]", "error after [%]", "noise floor [%]"),
    *("action", "judged", "by what"),
)
NOTE = (
    "Judged by a rule: right, where the first name is one of those that are true of the file, or"
    " the verdict says so; defensible, where such a one explains or helps, or a note says so;"
    " confidently wrong, where"
    " another effect is called missing, or the model adequate though something is missing; else"
    " hedged: nothing true is named, and nothing wrong is claimed."
)


class Unseen(NamedTuple):
    """A file and what is true of it.

    Attributes
    ----------
    file : str
        Its name, with the hint behind it.
    true : tuple of str
        Effects, or words of the headline, that an expert would name.
    source : str
        Who says what is true.
    """

    file: str
    true: tuple[str, ...]
    source: str


YIELDS = ("yielding", "power-law-slip", "power-law-damper", "friction", "elasto-sliding")
FILES = (
    Unseen("My_dow150-160-01 shear.shear", ("fading-network",), "RepTate: start-up, overshoot"),
    Unseen("CM3_Creep.creep", COMPLETE, "RepTate: steady flow of a melt"),
    Unseen("CM3_CreepRecovery.creep", COMPLETE, "RepTate: the same with recovery"),
    Unseen("C0224_NVT_450K_1atm.gt", COMPLETE, "RepTate: a simulation, noise alone"),
    Unseen("rel_lapo_1200.csv?time=s,relaxation=Pa", ("finite-ramp", "ageing"), "pyRheo"),
    Unseen("stressrelaxation_pp_data.csv?time=s,relaxation=Pa", COMPLETE, "pyRheo: Zener"),
    Unseen(
        "epstein.csv?omega=rad/s,storage=Pa,loss=Pa",
        (*COMPLETE, "the measuring chain rather than the material"),
        "pyRheo: two springpots in series, digitised",
    ),
    Unseen("time_user_raw.csv", ("wlf-shift", "free-shift"), "pyvisco: 21 temperatures"),
    Unseen("ensaio.A.1.mat?Tout=time[s],dist=displacement[mm],forc=force[N]", YIELDS, "MR damper"),
    Unseen(
        "AvgRelaxed_1s.csv?Time=time[s],L=displacement[um],F=force[N]",
        ("strain-stiffening", "slack"),
        "TitinViscoelasticity: slack and toe",
    ),
    Unseen(
        "HS60_10las_full_15.xls",
        (*YIELDS, "strain-softening"),
        "rheofit: the emulsion yields; loss above storage, and both fall beyond a strain",
    ),
    Unseen(
        "extract_t1_1_1_18_18_s6_n10_100psi_first1200lines.csv?force=-N",
        ("force-offset", "asymmetric-damping", *YIELDS),
        "damper_characterization: gas preload, digressive valve",
    ),
    Unseen(
        "extract_sample_Trios_1_steps_1_2.txt",
        ("changes with time", "ageing"),
        "read-rheol: an ageing gel",
    ),
    Unseen(
        "tts_plazek.csv?X=time[s],Y=compliance[1/Pa]",
        ("of another temperature", "wlf-shift", "free-shift"),
        "mastercurves: ten temperatures, which the file does not tell",
    ),
    Unseen(
        "230327_C_Indentation_relaxation_500N_force.xlsx",
        ("age or specimen", "specimen by specimen"),
        "Zwick: 17 specimens of different stiffness",
    ),
    Unseen(
        "3d0.xlsx?Time_s=time[s],CalculatedValue=strain[-],AdjustedForce=stress[kPa]",
        COMPLETE,
        "VHB 4910: one relaxation",
    ),
    Unseen(
        "creep_compliance.xlsx",
        ("wlf-shift", "arrhenius-shift", "free-shift"),
        "asphalt at temperatures",
    ),
)


def ask(one: Unseen, folder: Path = UNSEEN) -> dict[str, Any]:
    """What the tool says of a file; why not, where it is not here or does not open."""
    spec = str(folder / one.file)
    told: dict[str, Any] = {"file": one.file}
    if not (folder / one.file.partition("?")[0]).exists():
        return told | {"skipped": "not on this machine"}
    try:
        data = springpot.open_in_time(spec) or springpot.open_measurement(spec)
        found = springpot.diagnose(data)
    except SpringpotError as error:
        return told | {"skipped": str(error).replace(str(folder), "")[:120]}
    explains, helps = found.on_shelf("explains"), found.on_shelf("helps")
    return told | {
        "verdict": found.verdict,
        "says": found.says,
        "notes": list(found.notes),
        "explains": [row.effect for row in explains],
        "helps": [row.effect for row in helps],
        "missing": [row.effect for row in found.candidates if row.verdict == "missing"],
        "before": found.error.relative_rms,
        "after": next((row.after for row in [*explains, *helps]), None),
        "floor": found.error.noise_floor,
        "action": next((action.says for action in found.actions), ""),
    }


def judged(one: Unseen, told: dict[str, Any]) -> str:
    """Right, defensible, hedged or confidently wrong; see `NOTE`."""
    named = [*told["explains"], *told["helps"]]
    said = f"{told['verdict']}: {told['says']}"
    # A headline names a whole class: there too the first name alone is what is said.
    words = set(one.true) - set(named)
    if (named[:1] and named[0] in one.true) or any(word in said for word in words):
        return "right"
    claimed = set(told["missing"]) - set(one.true)
    if claimed or told["verdict"] == "adequate":
        return "confidently wrong"
    notes = " ".join(told.get("notes", ()))
    if set(named) & set(one.true) or any(word in notes for word in one.true):
        return "defensible"
    return "hedged"


def save(answers: Sequence[dict[str, Any]], folder: Path) -> None:
    """Keep the answers."""
    (folder / ANSWERS).parent.mkdir(parents=True, exist_ok=True)
    write_text(folder / ANSWERS, json.dumps(answers, indent=1) + "\n")


def saved(folder: Path) -> list[dict[str, Any]]:
    """The answers that were kept."""
    path = folder / ANSWERS
    return list(json.loads(path.read_text(encoding="utf-8"))) if path.exists() else []


def table(answers: Sequence[dict[str, Any]]) -> Table:
    """One row for each file, and one that counts."""
    known = {one.file: one for one in FILES}
    rows = list(_rows(answers, known))
    words = [row[7] for row in rows if row[7] is not None]
    count = counted(words)
    empty = (None,) * (len(COLUMNS) - 3)
    goal = "goal: right or defensible in 85 %, confidently wrong 0"
    rows.append((goal, *empty, count, None))
    return asking(__doc__, Table("Files of other people", COLUMNS, rows, NOTE))


def _rows(
    answers: Sequence[dict[str, Any]], known: dict[str, Unseen]
) -> Iterator[tuple[Entry, ...]]:
    for told in answers:
        one = known[told["file"]]
        file = one.file.partition("?")[0]
        if "skipped" in told:
            yield (file, told["skipped"], *(None,) * 6, one.source)
            continue
        names = " or ".join((told["explains"] or told["helps"])[:3]) or None
        after = None if told["after"] is None else round(100.0 * told["after"], 3)
        numbers = (round(100.0 * told["before"], 3), after, round(100.0 * told["floor"], 3))
        yield (
            *(file, told["verdict"], names, *numbers),
            *(told["action"] or None, judged(one, told), one.source),
        )
