"""What the engine raises when the user's input is wrong."""

from __future__ import annotations

from collections.abc import Iterable


class InputError(ValueError):
    """The input is wrong: which file or value, what is wrong with it, what to do about it.

    Parameters
    ----------
    subject : str
        The file or the value, as the user knows it.
    problem : str
        What is wrong, in one clause.
    remedy : str
        What to do; empty where nothing can be advised.
    """

    def __init__(self, subject: str, problem: str, remedy: str = "") -> None:
        self.subject = str(subject)
        self.problem = problem
        self.remedy = remedy
        super().__init__(f"{self.subject}: {problem}" + (f"; {remedy}" if remedy else ""))


def some(names: Iterable[str], most: int = 5) -> str:
    """Return the first names of many, and how many more there are, for a message."""
    known = list(names)
    return ", ".join(known[:most]) + (f" and {len(known) - most} more" if len(known) > most else "")


class Cancelled(Exception):  # noqa: N818  (not an error: the user asked for it)
    """Raised by a progress callback to stop a computation."""
