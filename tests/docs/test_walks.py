"""CONTRIBUTING names five walks through the sources, tools/walks.csv has their steps, and the sources have each of these."""

import csv
import sys
from collections import Counter

import pytest

from paths import ROOT

sys.path.insert(0, str(ROOT / "tools"))

from fortran import Program, read  # noqa: E402
from structure import SOURCES, shown_walk, walked, written_walks  # noqa: E402

PAGE = (ROOT / "CONTRIBUTING.md").read_text()
ROWS = list(csv.reader((ROOT / "tools/walks.csv").read_text().splitlines()))
WALKS = written_walks(PAGE, ROWS)
MOST_ROWS = 20
SMALL = Program({"main.f90": "program main\nuse run_m\ncall run()\nend program", "time/run.f90": """
module run_m
   use table_m
contains
   subroutine run()
      call inner()
   end subroutine
   subroutine inner()
      call row%find(1)
      call other()
   end subroutine
   subroutine other()
   end subroutine
end module""", "law/table.f90": """
module table_m
contains
   subroutine rows()
      row = row_t(find=first)
   end subroutine
   subroutine first()
   end subroutine
end module"""})
START = [("main", "main.f90", "", "", "", "starts"), ("run", "time/run.f90", "main", "", "", "runs")]


@pytest.fixture(scope="module")
def program():
    return read(SOURCES)


def test_five_walks_are_there_and_each_step_is_shown():
    assert len(WALKS) == 5
    assert all((ROOT / model).is_file() for model, *_ in WALKS)
    assert max(Counter(row[0] for row in ROWS).values()) <= MOST_ROWS
    assert {step for _, steps, *_ in WALKS for step in steps} == {tuple(row[1:]) for row in ROWS[1:]} and all(row[-1] for row in ROWS)
    assert all(len(list(shown_walk(steps))) == len(steps) for _, steps, *_ in WALKS)


@pytest.mark.parametrize(("model", "steps", "files", "depth"), WALKS, ids=[model for model, *_ in WALKS])
def test_a_walk_is_in_the_sources_and_as_long_and_deep_as_told(program, model, steps, files, depth):
    found, deepest = walked(program, steps)
    print(f"{model}: {len(steps)} steps, {len(found)} files, {deepest} calls deep")
    assert (len(found), deepest) == (files, depth)


def test_files_and_calls_are_counted():
    more = [("first", "law/table.f90", "run", "find", "law/table.f90", ""), ("other", "time/run.f90", "run", "", "", "")]
    assert walked(SMALL, START + more) == ({"main.f90", "time/run.f90", "law/table.f90"}, 3)


@pytest.mark.parametrize(("step", "message"), [
    (("gone", "time/run.f90", "run", "", "", ""), "there is no gone"), (("first", "time/run.f90", "run", "", "", ""), "there is no first"),
    (("other", "time/run.f90", "inner", "", "", ""), "inner is no step before it"), (("other", "time/run.f90", "", "", "", ""), "the caller is no step"),
    (("other", "time/run.f90", "main", "", "", ""), "main does not call run_m.other"), (("first", "law/table.f90", "run", "", "", ""), "does not call"),
    (("first", "law/table.f90", "run", "mark", "law/table.f90", ""), "does not call"),
    (("first", "law/table.f90", "run", "find", "main.f90", ""), "does not bind first")])
def test_steps_that_the_sources_do_not_have_are_found(step, message):
    with pytest.raises(ValueError, match=message):
        walked(SMALL, [*START, step])
