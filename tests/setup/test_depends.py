"""tools/depends.awk: make rules from module and use statements, in every spelling."""

import subprocess
from pathlib import Path

import pytest

DEPENDS = Path(__file__).resolve().parents[2] / "tools" / "depends.awk"
KINDS = "module hampm_kinds\nend module\n"
OF_KINDS = "$(O)/hampm_kinds.mod: $(O)/kinds.o ;"


@pytest.fixture
def rules(tmp_path):
    """The rules for sources given as name=text, in this order; those of modules first, sorted."""
    def call(*options, **sources):
        for name, text in sources.items():
            (tmp_path / f"{name}.f90").write_text(text)
        files = [tmp_path / f"{name}.f90" for name in sources]
        lines = subprocess.run(["awk", *options, "-f", DEPENDS, *files], check=True, capture_output=True, text=True).stdout.splitlines()
        return sorted(line for line in lines if ".mod: " in line) + [line for line in lines if ".mod: " not in line]
    return call


@pytest.mark.parametrize("use", [
    "use hampm_kinds", "  USE Hampm_Kinds, only: dp", "use :: hampm_kinds", "use, non_intrinsic :: hampm_kinds",
    "use hampm_kinds, only: &\n  dp  ! two lines", "use &\n  hampm_kinds", "use hampm_kinds; use other",
    "use other; use hampm_kinds", "use hampm_kinds\r"])
def test_every_spelling_of_use(rules, use):
    assert rules(step=f"program step\n{use}\nend\n", kinds=KINDS) == [OF_KINDS, "$(O)/step.o: $(O)/hampm_kinds.mod"]


@pytest.mark.parametrize("text", [
    "use, intrinsic :: hampm_kinds", "! use hampm_kinds", "useful = hampm_kinds", "use = 1",
    "print *, 'a &\n use of hampm_kinds'", "use iso_c_binding"])
def test_what_is_no_dependency(rules, text):
    assert rules(step=f"program step\n{text}\nend\n", kinds=KINDS) == [OF_KINDS]


def test_a_submodule_depends_on_its_ancestor(rules):
    assert rules(kinds=KINDS, part="submodule (hampm_kinds:middle) last\nend\n") == [OF_KINDS, "$(O)/part.o: $(O)/kinds.o"]


def test_module_procedures_are_no_modules(rules):
    text = "module hampm_a\ninterface g\n  module procedure hampm_kinds\nend interface\nend module hampm_a\n"
    assert rules(kinds=KINDS, a=text, b="use hampm_kinds\nuse hampm_a\nend\n") == [
        "$(O)/hampm_a.mod: $(O)/a.o ;", OF_KINDS, "$(O)/b.o: $(O)/hampm_kinds.mod $(O)/hampm_a.mod"]


def test_each_dependency_once_and_never_on_itself(rules):
    text = "module one\nuse hampm_kinds\nend module\nmodule two\nuse one\nuse hampm_kinds\nend module\n"
    assert rules(a=text, kinds=KINDS)[1:] == ["$(O)/one.mod: $(O)/a.o ;", "$(O)/two.mod: $(O)/a.o ;", "$(O)/a.o: $(O)/hampm_kinds.mod"]


def test_the_folder_may_be_given(rules):
    assert rules("-v", "folder=build/debug", kinds=KINDS, a="use hampm_kinds\nend\n") == \
        ["build/debug/hampm_kinds.mod: build/debug/kinds.o ;", "build/debug/a.o: build/debug/hampm_kinds.mod"]
