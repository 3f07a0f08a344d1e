"""The comparison of all numbers with an earlier version (tools/same_numbers.py): it sees a difference, and knows rounding from it."""

import sys

import pytest

from paths import PROGRAM, ROOT

sys.path.insert(0, str(ROOT / "tools"))

import same_numbers  # noqa: E402


def verdict(tmp_path, before, now=None):
    """The row of a model: before, and with the words `now` for the present program."""
    program = tmp_path / "program"
    program.write_text(f'#!/bin/sh\nexec {PROGRAM} "$@" {now or ""}\n')
    program.chmod(0o755)
    return same_numbers.row((PROGRAM, program), (before, before), {}, 60)


@pytest.fixture
def block(tmp_path):
    """A cell that vibrates."""
    file = tmp_path / "block.nml"
    file.write_text((ROOT / "docs/lessons/3_energy.nml").read_text())
    return same_numbers.Case("block", file)


@pytest.mark.parametrize(("words", "extent", "judged"), [
    ("", "whole", "same"),
    ("--set material.young=1.00000000000000045", "whole", "rounding"),
    ("--set material.young=1.0001", "whole", "DIFFERENT"),
    ("--set output.history_interval=0.005", "whole", "DIFFERENT"),
    ("--set material.young=-1", "whole", "DIFFERENT")])
def test_a_difference_is_seen_and_rounding_is_none(tmp_path, block, words, extent, judged):
    found = verdict(tmp_path, block, words)
    assert (found[1], found[-1]) == (extent, judged), found


def test_a_model_that_is_gone_is_a_difference(block):
    assert same_numbers.row((PROGRAM, PROGRAM), (block, None), {}, 60)[-1] == "DIFFERENT"


def test_all_models_are_found(tmp_path):
    found = same_numbers.cases_in(ROOT, tmp_path)
    assert {"input/dcb.nml", "README.md 1", "docs/lessons/3_energy.nml", "tests/regression/chen/case.nml 0.2mm"} <= set(found)


def test_columns_have_their_present_names():
    names = {"G_nodal_force_I": "G_vcct_I", "J_spread": "J_dependence"}
    assert [same_numbers.renamed(name, names) for name in ("G_nodal_force_I_error_tip2", "J_spread", "J")] == [
        "G_vcct_I_error_tip2", "J_dependence", "J"]
