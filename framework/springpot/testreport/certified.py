"""What a code asks of tests, answered: its rows, its verdict and its reasons."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .code import TestCode
from .deciding import CONFORMING, FAILING, UNDECIDED, DecidedRow, FoundFactor
from .report import CycleReport


@dataclass(frozen=True)
class Reason:
    """Why a test fails.

    Parameters
    ----------
    test : str
        Its name.
    says : tuple of str
        What a diagnosis finds in its record, and what goes with the temperature.
    effects : tuple of str
        The hidden effects that are named, the likeliest first.
    """

    test: str
    says: tuple[str, ...]
    effects: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {"test": self.test, "says": list(self.says), "effects": list(self.effects)}


@dataclass(frozen=True, eq=False)
class CertifiedTests:
    """What a code asks of tests, answered.

    Parameters
    ----------
    code : TestCode
        What was asked.
    report : CycleReport
        The tests.
    rows : tuple of DecidedRow
        Each result against its limits.
    factors : tuple of FoundFactor
        Property modification factors, the last of them all together.
    missing : tuple of str
        Tests that are asked for and are not there.
    left_out : tuple of str
        Files that could not be used, each with its reason.
    reasons : tuple of Reason
        Why the worst tests fail.
    """

    code: TestCode
    report: CycleReport
    rows: tuple[DecidedRow, ...]
    factors: tuple[FoundFactor, ...]
    missing: tuple[str, ...]
    left_out: tuple[str, ...]
    reasons: tuple[Reason, ...]

    @property
    def verdict(self) -> str:
        """``conforming``, ``undecided`` or ``not conforming``; the worst of all rows."""
        verdicts = {row.verdict for row in self.rows}
        if self.missing or FAILING in verdicts:
            return FAILING
        return UNDECIDED if UNDECIDED in verdicts else CONFORMING

    @property
    def says(self) -> str:
        """The verdict in one sentence."""
        counts = {word: sum(row.verdict == word for row in self.rows) for word in
                  (CONFORMING, UNDECIDED, FAILING)}  # fmt: skip
        told = ", ".join(f"{count} {word}" for word, count in counts.items() if count)
        lack = f"; {len(self.missing)} required tests are missing" if self.missing else ""
        return f"{self.verdict}: of {len(self.rows)} rows {told}{lack}"

    @property
    def standing(self) -> str:
        """Who stands for the code."""
        if self.code.status == "signed":
            return f"signed by {self.code.signed_by}"
        return (
            "unchecked: nobody with the text of the standard has compared this file with it;"
            " its numbers are no standard's"
        )

    def to_dict(self) -> dict[str, Any]:
        """As plain data, schema ``springpot.certificate/1``."""
        return {
            "schema": "springpot.certificate/1",
            "code": {
                "name": self.code.name,
                "status": self.code.status,
                "signed_by": self.code.signed_by or None,
                "source": self.code.source,
                "guard": self.code.guard,
            },
            "verdict": self.verdict,
            "says": self.says,
            "rows": [row.to_dict() for row in self.rows],
            "factors": [factor.to_dict() for factor in self.factors],
            "missing": list(self.missing),
            "left_out": list(self.left_out),
            "reasons": [reason.to_dict() for reason in self.reasons],
            "tests": [test.to_dict() for test in self.report.tests],
        }
