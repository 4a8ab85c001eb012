"""What a title says beside name and unit.

That the column holds logarithms, and for which curve it is: ``log10 G' [Pa]``, ``ln omega``; ``G'
at 20 °C [Pa]``, ``tan d (1 Hz)``. Which modulus it tells of: by its letter, as G' or E(t), or
words, as shear or tensile. Whether an amplitude is counted from trough to crest, or from the
middle.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

_LOGARITHM = re.compile(
    r"(log[ _]?\(?10\)?|log₁₀|lg|ln|log[ _]?(?-i:e)(?![a-z'′’])|log)([\s_({\[]*)(.+)\Z",
    re.IGNORECASE,
)
_BASES = {"lg": "10", "ln": "e", "loge": "e", "log10": "10", "log₁₀": "10", "log": "?"}
_QUANTITY = re.compile(
    r"[\s_,;@(\[]*(?:(?<![^\W_])(?:at|bei|T|f|ω|omega)\b)?[\s=@]*(?<![^\W_])(?<![.,])([-+−]?\d{1,9}(?:[.,]\d{1,9})?)[\s_]?"
    r"(°\s?C|℃|º\s?C|deg\s?C|C|°\s?F|kHz|mHz|Hz|rad/s)(?![^\W_])\s*[)\]]?",
)
_UNITS = {"C": "degC", "F": "degF"}
LONGEST = 120
"""Signs of a cell that are looked at: the pattern of a quantity may try each of them from each."""
_PLAIN = re.compile(r"(.*?['\w)])(?:[\s_\-.#]+|\s*\()([^\W_][\w.+-]{0,19}|\d[\d.]*)\)?\Z")
_DERIVED = frozenset(
    (
        *(
            "model",
            "fit",
            "fitted",
            "calc",
            "calculated",
            "theory",
            "pred",
            "predicted",
            "sim",
            "simulated",
        ),
        *(
            "residual",
            "std",
            "sd",
            "stdev",
            "err",
            "error",
            "unc",
            "uncertainty",
            "min",
            "max",
            "mean",
            "avg",
        ),
        *(
            "average",
            "median",
            "norm",
            "normalized",
            "normalised",
            "smooth",
            "smoothed",
            "shifted",
            "master",
        ),
        *(
            "reduced",
            "ratio",
            "raw",
            "corrected",
            "uncorrected",
            "set",
            "target",
            "cmd",
            "command",
            "limit",
        ),
        *("ref", "reference", "slope", "index", "modulus"),
    )
)
"""Words that say that a column is no further curve but another form of the same."""


@dataclass(frozen=True)
class CurveName:
    """Which of several curves a column belongs to.

    Parameters
    ----------
    text : str
        As the file has it, such as ``20 °C`` or ``sample A``.
    title : str
        The condition that this states, such as ``temperature [degC]``; empty for a mere name.
    value : str
        Its number.
    bare : bool
        Whether a temperature is written as ``20C``, which may be a name.
    """

    text: str
    title: str = ""
    value: str = ""
    bare: bool = False

    @property
    def role(self) -> str:
        """The role of the condition."""
        return self.title.partition(" ")[0]


@lru_cache(maxsize=2048)
def logarithm(title: str) -> tuple[str, str] | None:
    """Base (``10``, ``e``, or ``?`` where it is not said) and what is within.

    None for other titles.
    """
    match = _LOGARITHM.match(title)
    if match is None:
        return None
    word = re.sub(r"[ _()]", "", match[1].lower())
    opened, inner = match[2].strip(" _"), match[3].strip()
    if opened:
        inner = _without_closing(inner, opened[0])
    if not inner:
        return None
    return _BASES[word], inner


def _without_closing(inner: str, opened: str) -> str:
    """What stands within the bracket, and a unit behind it: ``G') [Pa]`` as ``G' [Pa]``."""
    closing = {"(": ")", "[": "]", "{": "}"}[opened]
    depth = 0
    for place, sign in enumerate(inner):
        depth += (sign in "([{") - (sign in ")]}")
        if depth < 0 and sign == closing:
            return f"{inner[:place]} {inner[place + 1 :]}".strip()
    return inner


def curve_of_number(text: str, unit: str, whole: str = "") -> CurveName:
    """The condition of a number with a unit."""
    # Keyboards have three signs that look like a degree.
    plain = unit.replace("º", "°").replace("℃", "°C").replace("°", "").replace("deg", "").strip()
    known = _UNITS.get(plain, plain)
    name = "frequency"
    if known == "rad/s":
        name = "omega"
    elif known.startswith("deg"):
        name = "temperature"
    value = text.replace("−", "-").replace(",", ".").lstrip("+")
    return CurveName(
        whole or f"{text} {unit}", f"{name} [{known}]", value, unit == "C" and "=" not in whole
    )


@lru_cache(maxsize=2048)
def curve_in_title(title: str) -> tuple[str, CurveName] | None:
    """A title without its temperature or frequency, and these; None for other titles."""
    match = _QUANTITY.search(title)
    # A number at the very beginning is no remark on a name, but a value or a name of its own.
    if match is None or match.start() == 0:
        return None
    # A bracket that holds more than the number stays with the title.
    left, right = (
        match[0].count("(") + match[0].count("["),
        match[0].count(")") + match[0].count("]"),
    )
    if left != right:
        return None
    stem = f"{title[: match.start()]} {title[match.end() :].lstrip()}".strip()
    stem = re.sub(r"\s+_|_\s+", "_", stem)
    return stem, curve_of_number(
        match[1], match[2], re.sub(r"^at\s+", "", match[0].strip(" _,;@()[]"))
    )


@lru_cache(maxsize=2048)
def curve_in_suffix(name: str) -> tuple[str, CurveName] | None:
    """A name without its last word, and this as the name of a curve: ``G'_A``.

    None for other names.
    """
    match = _PLAIN.match(name)
    # "fit2" is a second fit, no second measurement.
    if match is None or re.sub(r"[\d.]+$", "", match[2].lower()) in _DERIVED:
        return None
    return match[1], CurveName(match[2])


@lru_cache(maxsize=2048)
def curve_in_cell(text: str) -> CurveName:
    """What a cell above the columns of one curve says of it: ``T = 20 °C``, ``20 °C`` or a name."""
    text = text[:LONGEST]
    match = _QUANTITY.search(f" {text}")
    if match is not None and re.fullmatch(
        r"\s*(?:T|temp\.?|temperatur[ea]?|température|f|freq\.?|frequency|frequenz)?\s*[=:]?\s*",
        f" {text}"[: match.start()],
        re.IGNORECASE,
    ):
        curve = curve_of_number(match[1], match[2], text)
        if match.end() == len(text) + 1 and not curve.bare:
            return curve
    return CurveName(text)


_SWEEP = re.compile(r"(?:\A|[^A-Za-z])([GEK])(?:['′’´`*]|_?prime|p(?![A-Za-z]))")
"""``G'``, ``|E*|``, ``Storage modulus (G′)``; primes as programs spell them."""
_TIMED = re.compile(r"(?:\A|[^A-Za-z])([GEJD])\s*\(t\)")
"""``G(t)``, ``E(t)``, and the compliances J of shear and D of tension."""
_OF_COMPLIANCE = {"J": "G", "D": "E"}
_WORDS = {
    "G": re.compile(r"\bshear\b", re.IGNORECASE),
    "E": re.compile(r"\b(?:young|tensile|flexural|elongational)\b", re.IGNORECASE),
    "K": re.compile(r"\bbulk\b", re.IGNORECASE),
}


def letter_of(titles: Iterable[str], is_modulus: bool) -> str:
    """G, E or K (bulk modulus or stiffness) of the first title that tells; empty if none does."""
    for title in titles:
        match = _SWEEP.search(title) or _TIMED.search(title)
        if match:
            letter = _OF_COMPLIANCE.get(match[1], match[1])
            # In N/mm a G is no modulus; in Pa a K may be the bulk modulus or any: it is better
            # asked for.
            if is_modulus == (letter != "K"):
                return letter
        named = [letter for letter, word in _WORDS.items() if word.search(title)]
        if is_modulus and len(named) == 1:
            return named[0]
    return ""


_WHOLE_SWING = re.compile(
    # A title's underscore parts words as a blank does, and in a tidied unit "p-p" has become "p p".
    r"(?<![^\W_])(?:pk|peak)[\s_-]*(?:to)?[\s_-]*(?:pk|peak)(?![^\W_])|(?<![^\W_])p[\s_]*[-/\s_][\s_]*p(?![^\W_])"
    # In capitals PP may be polypropylene, the name of a curve.
    r"|(?<![^\W_])pp$|(?<![^\W_])(?-i:pp)(?![^\W_])|(?<=mm)pp|両振幅|全振幅|双振幅"
    r"|\bdouble[\s_]amplitude|\bdoppelamplitude|cr[êe]te[\s-]+(?:à|a)[\s-]+cr[êe]te|spitze[\s-]*(?:zu)?[\s-]*spitze",
    re.IGNORECASE,
)
_FROM_ZERO = re.compile(
    r"(?<![^\W_])(?:0|zero)[\s_-]*(?:to)?[\s_-]*(?:pk|peak|p)(?![^\W_])|±|\+/-", re.IGNORECASE
)
_PEAK = re.compile(r"\b(?:pk|peak)\b(?![\s-]*(?:to|pk|peak))", re.IGNORECASE)
_LEFT = re.compile(r"[\[(]\s*[\])]")
"""Brackets that held nothing else."""


def says_whole_swing(text: str) -> bool:
    """Whether a text says that an amplitude counts from trough to crest."""
    return bool(_WHOLE_SWING.search(text))


def without_swing(title: str) -> str:
    """A title without the words that say plainly from where an amplitude counts.

    A mere "peak" stays: the peak of a strain may have a static part.
    """
    return _tidied(_FROM_ZERO.sub(" ", _WHOLE_SWING.sub(" ", title)))


def without_peak(unit: str) -> str:
    """A unit without all of these words: ``mm`` of ``mm pk-pk`` and of ``mm peak``."""
    return _PEAK.sub("", _FROM_ZERO.sub("", _WHOLE_SWING.sub("", unit))).strip(" -()")


def _tidied(title: str) -> str:
    return " ".join(_LEFT.sub(" ", title).split()).strip(" -_")
