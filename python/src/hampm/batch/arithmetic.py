"""Arithmetic in the texts of a sweep: '${0.1 / n}' stands for its value. Nothing else of Python can be done by it.

Numbers, + - * / // % **, parentheses, names, and the functions and constants of FUNCTIONS and CONSTANTS. Whole results are written as whole
numbers, so that they do for keys that need these.
"""

import ast
import math
import operator
import re
from collections.abc import Callable
from typing import Any

ValueOf = Callable[[str], str]  # what a name stands for, a number or a text

EXPRESSION = re.compile(r"\$\{([^{}]*)\}")
LONGEST = 300  # letters of an expression
FUNCTIONS: dict[str, Callable[..., Any]] = {"sqrt": math.sqrt, "exp": math.exp, "log": math.log, "log2": math.log2, "log10": math.log10, "sin": math.sin, "cos": math.cos,
             "tan": math.tan, "asin": math.asin, "acos": math.acos, "atan": math.atan, "atan2": math.atan2, "hypot": math.hypot,
             "radians": math.radians, "degrees": math.degrees, "abs": abs, "min": min, "max": max, "round": lambda number: round(number), "floor": math.floor,
             "ceil": math.ceil}
CONSTANTS = {"pi": math.pi}
BINARY: dict[type, Callable[[Any, Any], Any]] = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv, ast.FloorDiv: operator.floordiv,
          ast.Mod: operator.mod, ast.Pow: lambda base, exponent: float(base) ** exponent if abs(exponent) > 16 else base ** exponent}
UNARY: dict[type, Callable[[Any], Any]] = {ast.UAdd: operator.pos, ast.USub: operator.neg}
LARGEST_WHOLE = 10**15  # up to which numbers without a fraction are written without one


class ExpressionError(Exception):
    """What is wrong with an expression, in words."""


def substitute(text: str, value_of: ValueOf) -> str:
    """A text with the values of its expressions; `value_of(name)` is the number or the text that a name stands for, or raises ExpressionError."""
    return EXPRESSION.sub(lambda found: written(evaluate(found[1], value_of)), text)


def evaluate(expression: str, value_of: ValueOf) -> int | float:
    """The value of an expression, a finite number."""
    if len(expression) > LONGEST:
        raise ExpressionError(f"an expression has at most {LONGEST} letters")
    try:
        value = _value(ast.parse(expression.strip(), mode="eval").body, value_of)
        if isinstance(value, complex) or not math.isfinite(value):
            raise ValueError("its value is no finite number")
    except ExpressionError as error:
        raise ExpressionError(f"${{{expression}}}: {error}") from error
    except (SyntaxError, MemoryError, RecursionError) as error:
        raise ExpressionError(f"${{{expression}}}: is no expression") from error
    except (ArithmeticError, ValueError, TypeError) as error:
        raise ExpressionError(f"${{{expression}}}: {error}") from error
    return value


def written(value: int | float) -> str:
    """A number as hampm reads it."""
    if float(value).is_integer() and abs(value) < LARGEST_WHOLE:
        return str(int(value))
    return repr(float(value))


def _value(node: ast.AST, value_of: ValueOf) -> Any:
    """The value of a part of an expression."""
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return _short(value)
        case ast.BinOp(left=left, op=sign, right=right) if type(sign) in BINARY:
            return _short(BINARY[type(sign)](_value(left, value_of), _value(right, value_of)))
        case ast.UnaryOp(op=sign, operand=operand) if type(sign) in UNARY:
            return UNARY[type(sign)](_value(operand, value_of))
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if name in FUNCTIONS:
            return FUNCTIONS[name](*(_value(argument, value_of) for argument in arguments))
        case ast.Name(id=name) if name in CONSTANTS:
            return CONSTANTS[name]
        case ast.Name(id=name):
            return _number(name, value_of)
        case ast.Attribute(value=ast.Name(id=group), attr=key):
            return _number(f"{group}.{key}", value_of)
    raise ExpressionError(f"numbers, names, + - * / // % ** and {', '.join(FUNCTIONS)} are known, and nothing else")


def _short(value: int | float) -> int | float:
    """A number, whole ones only as long as they cannot grow for ever."""
    return value if not isinstance(value, int) or abs(value) < LARGEST_WHOLE else float(value)


def _number(name: str, value_of: ValueOf) -> int | float:
    """What a name stands for, as a number."""
    text = value_of(name)
    try:
        value = float(text)
    except ValueError as error:
        raise ExpressionError(f"{name} is '{text}', no number") from error
    return int(value) if value.is_integer() and abs(value) < LARGEST_WHOLE else value
