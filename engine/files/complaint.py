"""What pydantic has to say about a value, in the words of an ``InputError``."""

from __future__ import annotations

from typing import Any, NamedTuple

from pydantic import ValidationError

from engine.errors import InputError


class Complaint(NamedTuple):
    """The first finding of a validation: where it stands, what is wrong, whether it is only missing, what was given."""

    place: tuple[str, ...]
    problem: str
    is_missing: bool
    given: Any


def first_complaint(error: ValidationError) -> Complaint:
    """Return the first finding; its problem is one line that begins with a small letter."""
    first = error.errors(include_url=False, include_context=False)[0]
    message = " ".join(first["msg"].removeprefix("Value error, ").split())
    place = tuple(str(part) for part in first["loc"])
    return Complaint(place, message[:1].lower() + message[1:], first["type"] == "missing", first["input"])


def bad_field(error: ValidationError, subject: str, remedy: str = "") -> InputError:
    """Return the error that names ``subject`` (a file), the first bad field, what is wrong and what to do.

    Without a ``remedy``, a field that is missing is to be added and any other to be corrected.
    """
    complaint = first_complaint(error)
    field = ".".join(complaint.place)
    advice = remedy or ("add it" if complaint.is_missing else "correct it")
    return InputError(f"{subject}, {field}" if field else subject, complaint.problem, advice)
