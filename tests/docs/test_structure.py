"""Modules depend on each other in the order of the table in CONTRIBUTING.md, without cycles, and procedures have few arguments."""

import re
import sys
from collections import Counter
from pathlib import Path

import pytest

from paths import ROOT

sys.path.insert(0, str(ROOT / "tools"))

from fortran import Program, read  # noqa: E402
from structure import SOURCES, Calls, cycle, folder_imports, followed, graph_of, reading_order, svg, upward_imports, walks, what_is_in  # noqa: E402

MOST_ARGUMENTS = 12
MOST_FILES, DEEPEST = 15, 6  # from the namelist to G(t); calls of a step below the loop of a run
EXCEPTIONS = []  # (procedure with more arguments, why)
TABLE = """
## Reading the code

| folder | what is in it |
|---|---|
| `src/main.f90`, `program.f90` | the start |
| `src/simulation.f90` | the run; `other.f90` |
| `src/motion/` | the step |
| `src/base/` | kinds |
"""


def small(**uses):
    """The program of modules a, b, ... in files such as motion_a, in the folder motion, each with what it uses."""
    return Program({f"{name.replace('_', '/')}.f90": f"module {name.split('_')[-1]}\n{text}\nend module {name.split('_')[-1]}\n"
                    for name, text in uses.items()})


def with_many_arguments(program):
    """Titles of the procedures with too many arguments."""
    return [scope.title() for scope in program.procedures if len(scope.arguments) > MOST_ARGUMENTS]


def wrong(program, exceptions):
    """Procedures with too many arguments that are no exceptions; exceptions that are not needed; those that stand twice."""
    many, listed = with_many_arguments(program), [name for name, _ in exceptions]
    return (sorted(set(many) - set(listed)), sorted(set(listed) - set(many)),
            sorted(name for name, n in Counter(listed).items() if n > 1))


@pytest.fixture(scope="module")
def program():
    return read(SOURCES)


@pytest.fixture(scope="module")
def order():
    return reading_order((ROOT / "CONTRIBUTING.md").read_text())


# --- the sources ------------------------------------------------------------------------------------------------------

def test_picture_of_the_folders_shows_what_the_sources_use_and_the_table_says(program, order):
    assert svg(program, order, what_is_in((ROOT / "CONTRIBUTING.md").read_text())) == (ROOT / "docs/images/rooms.svg").read_text(), "make structure"


def test_every_folder_has_a_row_in_the_table_and_every_row_its_files(order):
    assert len(order) > 10
    assert Counter(order).most_common(1)[0][1] == 1
    assert {path.name for path in SOURCES.iterdir() if path.is_dir()} == {name for name in order if not name.endswith(".f90")}
    assert [name for name in order if not (SOURCES / name).exists()] == []


def test_no_module_uses_one_that_stands_above_it_in_the_table(program, order):
    assert len(program.modules) > 90
    assert upward_imports(program, order) == []


def test_there_is_no_cycle_of_modules_or_folders(program):
    assert cycle(program.imports()) == []
    assert cycle(graph_of(folder_imports(program))) == []


def test_the_way_from_the_namelist_to_g_is_short_and_a_step_is_flat(program):
    found = {way: (len(files), depth) for way, files, depth in walks(Calls(program))}
    assert all(depth <= DEEPEST for _, depth in found.values()), found
    assert found["in plain loops"][0] <= MOST_FILES and len(found) == 3, found


def test_a_model_is_as_it_was_read_wherever_it_goes():
    changed = re.compile(r"type\(model_t\), intent\((?:in)?out\)|^ *(?:s%)?model%[\w%()]+ *=[^=]", re.MULTILINE)
    outside = [path for path in SOURCES.rglob("*.f90") if path.parent.name != "input" and path.name not in ("program.f90", "choice.f90", "choice_runs.f90", "expected_error.f90")]
    assert len(outside) > 150
    assert [path.name for path in outside if changed.search(path.read_text())] == []
    assert changed.search("      s%model%paths(k)%points = x") and changed.search("type(model_t), intent(inout) :: model")


def test_procedures_have_few_arguments(program):
    assert wrong(program, EXCEPTIONS) == ([], [], [])
    assert all(reason for _, reason in EXCEPTIONS)


# --- what finds it ----------------------------------------------------------------------------------------------------

def test_the_order_is_that_of_the_table():
    assert reading_order(TABLE) == ["main.f90", "program.f90", "simulation.f90", "motion", "base"]


@pytest.mark.parametrize(("uses", "found"), [
    ({"motion_a": "use b", "base_b": ""}, []),
    ({"motion_a": "", "base_b": "use a"}, [("b", "a")]),
    ({"motion_a": "", "base_b": "use, non_intrinsic :: &\n & A, only: & ! for\n\n ! a reason\n &x\n"}, [("b", "a")]),
    ({"motion_a": "", "base_b": "contains\nsubroutine s()\n use a, only: x\nend subroutine s"}, [("b", "a")]),
    ({"motion_a": "", "base_b": "! use a\nreal :: x = 1 ! use a\ncharacter(5) :: t = 'a&\n&; use a'"}, []),
    ({"motion_a": "", "base_b": "use, intrinsic :: a"}, []),
    ({"motion_a": "", "base_b": "x = 1; use a"}, [("b", "a")]),
    ({"simulation": "use other; use a", "other": "use a", "motion_a": ""}, []),
    ({"simulation": "", "other": "use simulation", "motion_a": "use other"}, [("a", "other")]),
    ({"simulation": "use program", "program": ""}, [("simulation", "program")])])
def test_imports_against_the_order_are_found(uses, found):
    assert upward_imports(small(**uses), reading_order(TABLE)) == found


def test_cycles_are_found():
    assert cycle(small(a="use b", b="use c", c="").imports()) == []
    assert cycle(small(a="use b", b="use c", c="use b").imports()) == ["b", "c"]
    folders = small(motion_a="use b", base_b="", base_c="use d", motion_d="")
    assert cycle(folders.imports()) == []
    assert cycle(graph_of(folder_imports(folders))) == ["base", "motion"]


@pytest.mark.parametrize("head", [
    "subroutine s({})", "pure real(dp) function s({}) result(y)", "recursive subroutine s({}) bind(c, name='s')",
    "character(len(a1)) function s({})", "elemental type(t_t) function s({})"])
def test_arguments_are_counted(head):
    def source(n):
        arguments = ", &\n  ! of which\n  &".join(f"a{k}" for k in range(n))
        kind = "function" if "function" in head else "subroutine"
        return small(a=f"contains\n{head.format(arguments)}\nend {kind} s")
    assert with_many_arguments(source(MOST_ARGUMENTS)) == []
    assert with_many_arguments(source(MOST_ARGUMENTS + 1)) == ["a.s"]


def test_arguments_of_contained_procedures_and_bindings_count_and_those_of_foreign_ones_do_not():
    many = ", ".join(f"a{k}" for k in range(MOST_ARGUMENTS + 1))
    text = f"""
        type :: t
        contains
           procedure :: bound => s
        end type
        interface
           subroutine foreign({many})
           end subroutine
        end interface
        contains
        subroutine s(self)
        contains
           integer function inner({many})
           if (.true.) then
           end if
           end function
        endsubroutine s
        subroutine last({many})
        end"""
    assert with_many_arguments(small(a=text)) == ["a.s.inner", "a.last"]


def test_exceptions_that_are_not_needed_or_stand_twice_are_found():
    many = ", ".join(f"a{k}" for k in range(MOST_ARGUMENTS + 1))
    many = small(a=f"contains\nsubroutine s({many})\nend subroutine\nsubroutine few()\nend subroutine")
    assert wrong(many, []) == (["a.s"], [], [])
    assert wrong(many, [("a.s", "because"), ("a.few", "because"), ("a.s", "because")]) == ([], ["a.few"], ["a.s"])


CALLS = Program({Path("main.f90"): """
program main
   use b, only: t_t, renamed => run
   type(t_t) :: t
   call renamed(t)
end program
""", Path("b.f90"): """
module b
   interface either
      module procedure first, second
   end interface
   type :: inner_t
      real :: velocity(2)
   contains
      generic :: do => do_one
      procedure, private :: do_one
   end type
   type, public :: t_t
      type(inner_t) :: parts(3)
   end type
contains
   subroutine run(t)
      type(t_t), intent(inout) :: t
      real :: second
      second = 1
      associate (part => t%parts(2))
         call part%do(x=3 + &
            2)
      end associate
   end subroutine
   subroutine do_one(self, x)
      class(inner_t) :: self
      call kick(self%velocity(:))
   end subroutine
   subroutine kick(v)
      real :: v(:)
      v = v*either(1)
      print *, 'G_some_I'
   end subroutine
   real function first(i)
   end function
   real function second(i)
   end function
end module
"""})


def test_calls_are_followed_through_names_types_and_generic_procedures():
    calls = Calls(CALLS)
    assert [scope.title() for scope in calls.chain(calls.find("main"), calls.find("second"))] == [
        "main", "b.run", "b.do_one", "b.kick", "b.second"]
    assert "b.second" not in [callee.title() for callee, _ in calls.of[calls.find("run")]]
    assert calls.chain(calls.find("kick"), calls.find("run")) == []


def test_calls_of_a_binding_lead_to_all_that_override_it():
    calls = Calls(small(a="""
       type, abstract :: base_t
          real :: field
       contains
          procedure(advance_i), deferred :: advance
          procedure :: common
       end type
       type, extends(base_t) :: one_t
       contains
          procedure :: advance => one
       end type
       type, public, extends(one_t) :: two_t
       contains
          procedure :: advance => two
       end type
       abstract interface
          subroutine advance_i(self)
          end subroutine
       end interface
       contains
       subroutine run(self, other)
          class(base_t) :: self
          type(two_t) :: other
          call self%advance()
          call other%common()
       end subroutine
       subroutine one(self)
       end subroutine
       subroutine two(self)
       end subroutine
       subroutine common(self)
       end subroutine"""))
    assert [callee.title() for callee, _ in calls.of[calls.find("run")]] == ["a.one", "a.two", "a.common"]


def test_a_velocity_is_followed_to_whom_it_is_handed():
    assert followed(Calls(CALLS)) == {Path("b.f90"): "kick names a column of G", Path("main.f90"): "on the way there"}


def test_no_norm_depends_on_units():
    """`norm2` of gfortran scales by components from 1 on, and has another last digit in other units."""
    assert [file.name for file in (ROOT / "src").rglob("*.f90") if re.search(r"\bnorm2 *\(", file.read_text())] == []


# --- Python -----------------------------------------------------------------------------------------------------------

def test_no_two_python_modules_have_one_name():
    """Tests import from several folders at once: of two modules of one name the first in the path would be taken for both."""
    folders = "batch", "bench", "postprocess", "tools", "tests"   # those of the package are in a namespace of their own
    names = Counter(file.stem for folder in folders for file in (ROOT / folder).rglob("*.py") if file.stem != "conftest")
    assert [name for name, number in names.items() if number > 1] == []
