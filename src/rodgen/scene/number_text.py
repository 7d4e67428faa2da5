"""Numbers that a scene writes as constant expressions, such as "deg(30)" or "2*pi*f0"."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Self, TypeVar

from pydantic import (
    GetCoreSchemaHandler,
    PlainSerializer,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
)
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from rodgen.errors import InputError
from rodgen.scene.expression import parse_expression

T = TypeVar("T")


class NumberText(float):
    """A number that stands in a scene as the text of an expression: computed with as a number,
    written as its text."""

    text: str

    @classmethod
    def parse(cls, text: str, numbers: Mapping[str, float]) -> Self:
        """Evaluate a text; numbers: those that it may name. Raises InputError."""
        found = cls(parse_expression(text, "", "number", tuple(numbers.items()))(0.0))
        found.text = text
        return found


def to_texts(value: Any) -> Any:
    """Convert a number, or those of a list, to what a file has; anything else stays as it is."""
    if not isinstance(value, list):
        return getattr(value, "text", value)
    if NumberText not in {*map(type, value)}:  # as of most lists, some of a million numbers
        return [*value]
    return [getattr(one, "text", one) for one in value]


class _NumberOrText:
    """Annotation of a number that may be written as an expression."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        number = handler(source)
        parsed = core_schema.with_info_wrap_validator_function(_parse_text, number)
        text = core_schema.chain_schema([core_schema.str_schema(), parsed])
        return core_schema.union_schema(
            [number, text],
            mode="left_to_right",
            serialization=core_schema.plain_serializer_function_ser_schema(to_texts),
        )


def _parse_text(text: str, check: ValidatorFunctionWrapHandler, info: ValidationInfo) -> NumberText:
    """Evaluate a text and check its value; the context has the numbers of [parameters] by name."""
    try:
        number = NumberText.parse(text, info.context or {})
    except InputError as error:
        found = PydanticCustomError("expression", "{allowed}", {"allowed": error.allowed})
        raise found from None
    check(number)
    return number


Expressed = Annotated[T, _NumberOrText()]  # a number, or an expression of [parameters] alone
AS_TEXTS = PlainSerializer(to_texts)  # of a list of such numbers
