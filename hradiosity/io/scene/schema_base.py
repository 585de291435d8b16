"""Bricks of the scene format: tables that refuse unknown keys, numbers, vectors."""

from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, Strict
from pydantic_core import PydanticCustomError


class Table(BaseModel):
    """A table of the scene file; a key that it does not know is a fault, so that a misspelling is never ignored."""

    # Validators of tables inside others are never called by themselves: not building them halves the time.
    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, str_strip_whitespace=True, defer_build=True
    )


def three_numbers(value: Any) -> Any:
    """Refuse anything but a list of three, in words of the manual."""
    if not isinstance(value, list) or len(value) != 3:
        raise PydanticCustomError("vector", "three numbers in brackets are needed, [x, y, z]")
    return value


LARGEST = 1e9
"""Beyond this a number is a slip: squares and products of such numbers still have to be finite."""

Number = Annotated[float, Strict(), Field(ge=-LARGEST, le=LARGEST)]
Count = Annotated[int, Strict(), Field(ge=1, le=100_000)]
Positive = Annotated[float, Strict(), Field(gt=0, le=LARGEST)]
Share = Annotated[float, Strict(), Field(ge=-LARGEST, le=LARGEST, json_schema_extra={"minimum": 0, "maximum": 1})]
"""A number whose bounds 0 … 1 stand in the JSON Schema, but are checked later, in words that tell percent apart."""
Vector = Annotated[tuple[Number, Number, Number], BeforeValidator(three_numbers)]
Name = Annotated[str, Strict(), Field(min_length=1)]
Truth = Annotated[bool, Strict()]


def one_of(*keys: str) -> ConfigDict:
    """Configuration of a table of which `exactly_one` of the keys must be given: its JSON Schema says so too."""
    return ConfigDict(json_schema_extra={"oneOf": [{"required": [key]} for key in keys]})


def exactly_one(table: BaseModel, *keys: str) -> str:
    """The one key of ``keys`` that is given.

    Raises ``PydanticCustomError``, which pydantic turns into a fault of the scene file, when none or several are given.
    """
    given = [key for key in keys if getattr(table, key) is not None]
    if len(given) != 1:
        raise PydanticCustomError(
            "exactly_one",
            "exactly one of {choices} is needed, not {given}",
            {"choices": ", ".join(keys), "given": " and ".join(given) if given else "none"},
        )
    return given[0]
