"""Arithmetic in sweeps: what it computes, and that nothing else can be done by it."""

import math
import time

import pytest

from hampm.batch.arithmetic import ExpressionError, evaluate, substitute, written

VALUES = {"n": "8", "grid.cell": "1.25e-3", "mass": "lumped"}


def value_of(name):
    if name not in VALUES:
        raise ExpressionError(f"there is no {name}")
    return VALUES[name]


@pytest.mark.parametrize("text, result", [
    ("plain", "plain"), ("${n}", "8"), ("${1/n}", "0.125"), ("${n/2 + 1}", "5"), ("${2*n}, ${n + 2}", "16, 10"), ("a ${n}b", "a 8b"),
    ("${round(0.1/grid.cell)}", "80"), ("${log2(n)}", "3"), ("${-n**2}", "-64"), ("${7 // 2}", "3"), ("${7 % 4}", "3"), ("${max(1, n, 3.5)}", "8"),
    ("${2**-3}", "0.125"), ("${1e3}", "1000"), ("${1/3}", repr(1 / 3)), ("${ hypot(3, 4) }", "5"), ("$n", "$n"), ("${floor(2.7)}", "2")])
def test_values(text, result):
    assert substitute(text, value_of) == result


def test_constants_and_angles():
    assert evaluate("cos(radians(60))*pi", value_of) == pytest.approx(math.pi / 2)


@pytest.mark.parametrize("text, message", [
    ("m", "there is no m"), ("mass", "mass is 'lumped', no number"), ("1/0", "division by zero"), ("sqrt(-1)", "math domain error"),
    ("(-1)**0.5", "is no finite number"), ("1e308*10", "is no finite number"), ("10**400", "out of range"), ("1 +", "is no expression"), ("", "is no expression"),
    ("max()", "at least 1 argument"), ("'a'", "and nothing else"), ("True", "and nothing else"), ("n if n else 1", "and nothing else"),
    ("[1][0]", "and nothing else"), ("n.real.imag", "and nothing else"), ("(1).__class__", "and nothing else"), ("__import__('os')", "and nothing else"),
    ("open('/etc/passwd')", "and nothing else"), ("lambda: 1", "and nothing else"), ("round(5, -10**14)", "argument"), ("max(*[1])", "and nothing else"),
    ("max(1, 2, key=abs)", "and nothing else"), ("1 " * 200, "at most 300 letters"), ("(" * 290, "is no expression")])
def test_what_is_no_arithmetic(text, message):
    with pytest.raises(ExpressionError) as error:
        evaluate(text, value_of)
    assert message in str(error.value)


@pytest.mark.parametrize("text", ["9**9**9", "(" * 40 + "9" + "**9)" * 40, "*".join(["99999999999999"] * 20), "-" * 250 + "1"])
def test_no_expression_takes_long(text):
    begin = time.monotonic()
    try:
        assert math.isfinite(evaluate(text, value_of))
    except ExpressionError:
        pass
    assert time.monotonic() - begin < 1


def test_whole_numbers_are_written_as_such():
    """As keys ask for that are counted."""
    assert [written(value) for value in (80.0, 3, -2.0, 0.5, 1e20, -0.0)] == ["80", "3", "-2", "0.5", "1e+20", "0"]
