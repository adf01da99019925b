"""What the engine raises when the user's input is wrong."""

from __future__ import annotations


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


class Cancelled(Exception):  # noqa: N818  (not an error: the user asked for it)
    """Raised by a progress callback to stop a computation."""
