"""JSON from a file into a checked model, with the bad field named."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from engine.errors import InputError
from engine.files.complaint import bad_field
from engine.files.source import read_bytes

MAX_JSON_BYTES = 16 << 20

Model = TypeVar("Model", bound=BaseModel)


def load_json(path: str | Path) -> dict[str, Any]:
    """Return the object that a UTF-8 JSON file holds.

    Raises
    ------
    InputError
        When the file is not UTF-8 or not JSON, holds no object, or names a key twice.
    """
    data = read_bytes(path, MAX_JSON_BYTES)
    try:
        value = json.loads(data.decode("utf-8-sig"), object_pairs_hook=_without_duplicates)
    except UnicodeDecodeError as error:
        raise InputError(str(path), f"is not UTF-8 text (byte {error.start})", "save it as UTF-8") from error
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise InputError(str(path), f"is not JSON: {error.msg} at {where}", "correct or export it again") from error
    except _DuplicateKeyError as error:
        raise InputError(str(path), f"names {error.key!r} twice", "remove one of them") from error
    except (RecursionError, ValueError) as error:
        raise InputError(str(path), "is not JSON that can be read", "export it again") from error
    if not isinstance(value, dict):
        raise InputError(str(path), "holds no JSON object", "it must begin with '{'")
    return value


def checked(model: type[Model], value: Any, path: str | Path) -> Model:
    """Return ``value`` as ``model``; InputError names the file and the first bad field."""
    try:
        return model.model_validate(value)
    except ValidationError as error:
        raise bad_field(error, str(path)) from error


class _DuplicateKeyError(Exception):
    def __init__(self, key: str) -> None:
        self.key = key
        super().__init__(key)


def _without_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for key, value in pairs:
        if key in result:
            raise _DuplicateKeyError(key[:60])
        result[key] = value
    return result
