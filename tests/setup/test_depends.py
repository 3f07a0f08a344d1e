"""tools/depends.awk: make rules from module and use statements, in every spelling."""

import subprocess
from pathlib import Path

import pytest

DEPENDS = Path(__file__).resolve().parents[2] / "tools" / "depends.awk"
KINDS = "module hampm_kinds\nend module\n"


@pytest.fixture
def rules(tmp_path):
    """The rules for sources given as name=text, in this order."""
    def call(*options, **sources):
        for name, text in sources.items():
            (tmp_path / f"{name}.f90").write_text(text)
        files = [tmp_path / f"{name}.f90" for name in sources]
        return subprocess.run(["awk", *options, "-f", DEPENDS, *files], check=True, capture_output=True,
                              text=True).stdout.splitlines()
    return call


@pytest.mark.parametrize("use", [
    "use hampm_kinds", "  USE Hampm_Kinds, only: dp", "use :: hampm_kinds", "use, non_intrinsic :: hampm_kinds",
    "use hampm_kinds, only: &\n  dp  ! two lines", "use &\n  hampm_kinds", "use hampm_kinds; use other",
    "use other; use hampm_kinds", "use hampm_kinds\r"])
def test_every_spelling_of_use(rules, use):
    assert rules(step=f"module step\n{use}\nend module\n", kinds=KINDS) == ["$(O)/step.o: $(O)/kinds.o"]


@pytest.mark.parametrize("text", [
    "use, intrinsic :: hampm_kinds", "! use hampm_kinds", "useful = hampm_kinds", "use = 1",
    "print *, 'a &\n use of hampm_kinds'", "use iso_c_binding"])
def test_what_is_no_dependency(rules, text):
    assert rules(step=f"module step\n{text}\nend module\n", kinds=KINDS) == []


def test_a_submodule_depends_on_its_ancestor(rules):
    assert rules(kinds=KINDS, part="submodule (hampm_kinds:middle) last\nend\n") == ["$(O)/part.o: $(O)/kinds.o"]


def test_module_procedures_are_no_modules(rules):
    text = "module hampm_a\ninterface g\n  module procedure hampm_kinds\nend interface\nend module hampm_a\n"
    assert rules(kinds=KINDS, a=text, b="use hampm_kinds\nuse hampm_a\nend\n") == ["$(O)/b.o: $(O)/kinds.o $(O)/a.o"]


def test_each_dependency_once_and_never_on_itself(rules):
    text = "module one\nuse hampm_kinds\nend module\nmodule two\nuse one\nuse hampm_kinds\nend module\n"
    assert rules(a=text, kinds=KINDS) == ["$(O)/a.o: $(O)/kinds.o"]


def test_the_folder_may_be_given(rules):
    assert rules("-v", "folder=build/debug", kinds=KINDS, a="use hampm_kinds\nend\n") == \
        ["build/debug/a.o: build/debug/kinds.o"]
