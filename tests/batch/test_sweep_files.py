"""Sweep files that are changed at random."""

import pytest

pytest.importorskip("yaml")

import sweep_files
from hampm.batch.declaration import namelist_keys
from paths import PROGRAM


@pytest.mark.parametrize("cases", [300, pytest.param(5000, marks=pytest.mark.verify)])
def test_each_is_a_sweep_or_every_mistake_in_it_is_said(tmp_path, cases):
    ends, findings = sweep_files.try_sweeps(tmp_path, cases, 1, namelist_keys(PROGRAM))
    assert not findings
    assert ends["read"] > cases // 50 and ends["refused"] > cases // 2
