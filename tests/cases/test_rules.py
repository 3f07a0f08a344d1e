"""Scenes in which a key does nothing, or a group is dropped: refused or warned of by name, from the table of rules."""

import re

import pytest

HISTORIES = [("history_keys_ignored_table", ["&load times", "&load factors"], "history = 'table'"),
             ("history_keys_ignored_rise", ["&load rise_time"], "history = 'ramp'"),
             ("history_keys_ignored_constraint", ["&constraint times", "&constraint factors"], "history = 'table'")]


@pytest.mark.parametrize(("name", "keys", "missing"), HISTORIES, ids=[row[0] for row in HISTORIES])
def test_keys_of_another_history_are_refused_with_the_one_that_is_missing(case, name, keys, missing):
    result = case(name)
    assert result.code == 2
    for key in keys:
        assert re.search(rf"{name}\.nml:\d+: {key} = [^=]* requires {re.escape(missing)}$", result.stderr, re.MULTILINE), result.stderr


@pytest.mark.parametrize(("key", "needed"), [("rise_time", "ramp"), ("frequency", "sine"), ("times", "table"), ("factors", "table")])
@pytest.mark.parametrize("history", ["step", "ramp", "sine", "table"])
def test_every_key_of_a_history_is_refused_with_every_other_history(case, text_of, key, needed, history):
    """In the second of two loads, which the message names by its number."""
    own = {"step": "", "ramp": "rise_time=1e-7", "sine": "frequency=1e6", "table": "times=0,1e-6 factors=0,1"}[history]
    extra = "" if key in own else f"{key}=1.0"
    load = re.search(r"&load.*", text_of("history_keys_ignored_rise"))[0]
    second = load.replace("rise_time=1e-7", f"history='{history}' {own} {extra}").replace("8e-3,8e-3 upper=8e-3,8e-3", "8e-3,-8e-3 upper=8e-3,-8e-3")
    text = text_of("history_keys_ignored_rise").replace(load, load.replace(" rise_time=1e-7", "") + "\n" + second)
    result = case("second", "--check", text=text)
    if needed == history:
        assert result.code == 0, result.stderr
    else:
        assert result.code == 2
        assert f"&load(2) {key} = 1.0 requires history = '{needed}'" in result.stderr
        assert len(result.stderr.splitlines()) == 1


def test_a_crack_that_would_be_dropped(case):
    result = case("second_line_crack_dropped")
    assert result.code == 2
    for number, line in (1, 7), (2, 8):
        assert f"nml:{line}: &crack({number}) kind = 'line' is not allowed with several cracks" in result.stderr


@pytest.mark.parametrize("second", ["kind='symmetry' tip=0.0,-8e-3", "kind='path' points=-4e-3,3.2e-3,4e-3,3.3e-3"])
def test_a_crack_that_would_be_dropped_beside_one_of_another_kind(case, text_of, second):
    result = case("others", text=text_of("second_line_crack_dropped").replace("kind='line' tip=0.0,3e-3", second))
    assert result.code == 2
    assert "&crack(1) kind = 'line' is not allowed with several cracks" in result.stderr


def test_refinement_without_an_indicator(case):
    result = case("refine_without_indicator", "--check")
    assert result.code == 0
    assert "warning: &refine max_level = 3 has no effect without indicator = " in result.stderr
    assert "warning: &refine rings = 8 has no effect without indicator = 'tip'" in result.stderr


def test_what_is_printed_of_a_scene_has_no_key_without_effect(case, text_of):
    """`--check` prints every key with its value: those that are defaults say nothing."""
    text = text_of("refine_without_indicator").replace("&refine max_level=3 rings=8 /", "")
    printed = case("given", "--check", text=text)
    again = case("again", "--check", text=printed.stdout)
    assert printed.stderr == again.stderr == ""
