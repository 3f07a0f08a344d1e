"""Every procedure, type and module of src/ says above itself what it is; the API pages are made of that."""

import re

import pytest

from paths import ROOT

DEFINITION = re.compile(r"(?!end|!)(?:(?:pure|elemental|recursive|integer|logical|character|real|type)(?:\([^)]*\))? +)*"
                        r"(?:(?:subroutine|function|module|program) (?!procedure\b)(\w+)|type(?:, *\w+)* *:: *(\w+))")
SOURCES = sorted((ROOT / "src").glob("**/*.f90"))
FOREIGN = re.compile(r"^ *interface *$.*?^ *end interface *$", re.MULTILINE | re.DOTALL)


def undocumented(source):
    """Names of what a source defines without a docstring; interfaces of foreign procedures need none."""
    lines = FOREIGN.sub("", source).splitlines()
    found = [(DEFINITION.match(line.strip()), before.strip()) for before, line in zip(["", *lines], lines)]
    return [name[1] or name[2] for name, before in found if name and not before.startswith("!>")]


@pytest.mark.parametrize(("source", "missing"), [("!> What.\nmodule a\n", []), ("module a\n", ["a"]),
                                                 ("!> What.\npure real(dp) function f(x)\nend function f\nsubroutine s()", ["s"]),
                                                 ("type :: t\nend type t\ntype(t) :: v\n", ["t"]),
                                                 ("interface\n subroutine c()\n end subroutine c\nend interface\n", [])])
def test_definitions_without_a_docstring_are_found(source, missing):
    assert undocumented(source) == missing


def test_everything_has_a_docstring():
    assert len(SOURCES) > 90
    assert {path.name: names for path in SOURCES if (names := undocumented(path.read_text()))} == {}


def test_no_docstring_begins_with_a_word_and_a_colon():
    """ford takes such a line for metadata and leaves it out."""
    begin = re.compile(r"^(?! *!>).*\n *!> [\w-]+: ", re.MULTILINE)
    assert [path.name for path in SOURCES if begin.search("\n" + path.read_text())] == []


def test_lines_are_short():
    """As CONTRIBUTING.md says, comments too."""
    long = [f"{path.name}:{number}" for path in SOURCES for number, line in enumerate(path.read_text().splitlines(), 1) if len(line) > 132]
    assert long == []


def test_headers_of_modules_are_short():
    """A header says what a module is for and where its theory stands; the theory itself is in docs/explanation."""
    heads = {path.name: len(re.match(r"(?:!.*\n)*", path.read_text())[0].splitlines()) for path in SOURCES}
    assert {name: lines for name, lines in heads.items() if lines > 12} == {}


# A name and the bracket that it opens
OPENING = re.compile(r"\b[\w%]+\(")
# What takes a statement of its own to be found, unlike mod and merge
FOUND_BEFORE = "size max min sum product count findloc maxval minval maxloc minloc dot_product norm ubound floor ceiling".split()


def statements(source):
    """Code as whole statements, without comments and texts, each with the line that it begins in."""
    whole, begin = "", 0
    for number, line in enumerate(source.splitlines(), 1):
        code = (re.sub(r"'[^']*'|\"[^\"]*\"|!.*", "", line) if re.search(r"['\"!]", line) else line).strip()
        begin = begin if whole else number
        whole += code.strip("&") + " " * bool(code)
        if whole and not code.endswith("&") and code:
            yield begin, whole.strip()
            whole = ""


def parts_of(text):
    """What commas separate from the beginning up to a bracket that closes, and where that is."""
    parts, depth = [""], 0
    for at, letter in enumerate(text):
        depth += (letter in "([") - (letter in ")]")
        if depth < 0:
            return parts, at
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return parts, len(text)


def is_section(part):
    """Whether a subscript has a colon outside of brackets."""
    while re.search(r"\([^()]*\)", part):
        part = re.sub(r"\([^()]*\)", "", part)
    return ":" in part


def guessed_sections(source, functions):
    """Lines with an array section that is handed on as it is, to a procedure or a name, and of which another subscript is the result of a function. gfortran 14 asks, with
    -fcheck=bounds, for that subscript before it has the arguments of the function."""
    calls = re.compile(rf"%(?:{'|'.join(functions)})\(|(?<![%\w])(?:{'|'.join(FOUND_BEFORE)})\(|(?<![%\w])(?:{'|'.join(functions)})\([^()]*[-+*/(]")
    found = []
    for number, code in statements(source):
        if ":" not in code or re.match(r"(?:real|integer|logical|character|type|class)\b.*::|(?:\w+ )*(?:subroutine|function) |allocate \((?!.*source=)", code):
            continue
        for opening in OPENING.finditer(code):
            if not re.search(r"(?:[(,]|=>|[(,] *\w+ *=) *$", code[:opening.start()]):
                continue
            parts, length = parts_of(code[opening.end():])
            is_whole = re.match(r" *[,)]", code[opening.end() + length + 1:])
            if is_whole and any(map(is_section, parts)) and any(calls.search(part) for part in parts if not is_section(part)):
                found.append(f"{number}: {opening[0]}{','.join(parts)})")
    return found


def names_of_functions(sources):
    """Functions whose type stands before them, which are scalar ones, by their names and those of type-bound procedures."""
    scalar = set(re.findall(r"^ *(?:(?:pure|elemental|recursive) )*(?:integer|real\(dp\)|logical) function (\w+)\(", sources, re.MULTILINE))
    return sorted(scalar | {new for new, old in re.findall(r"procedure *(?:, *\w+ *)*:: *(\w+)(?: *=> *(\w+))?", sources) if (old or new) in scalar})


@pytest.mark.parametrize(("line", "count"), [
    ("associate (cell => matrix%cell(:, :, matrix%cell_of(cells(k))))", 1), ("call take(m%cell(:, m%cell_of(e)), n)", 1), ("allocate (a, source=b(:, max(k, 1)))", 1),
    ("x = spread(at(:, f%n()/2 + 1), 1, p%n)", 1), ("x = norm(at(:, maxloc(r, dim=1)))", 1), ("b = a(:, m%cell_of(k))", 0), ("x = norm(at(:, size(at, 2)))", 1),
    ("x = norm(at(:, n) - at(:, f%n()))", 0), ("x = norm(at(:, cell_of(k + 1)))", 1), ("is(at(:, cell_of(k))) = .true.", 0),
    ("associate (cell => matrix%cell_of(cells(k)))", 0), ("x = norm(at(:, modulo(k, n) + 1))", 0), ("print *, 'a(', f(b(:, l(k)))", 0)])
def test_sections_by_a_function_are_found(line, count):
    assert len(guessed_sections(line, ["cell_of", "n"])) == count


def test_no_section_by_a_function_is_handed_on():
    """gfortran 14 with -fcheck=bounds, as of the checked build, reads what is not yet set: it ends by a signal, or says that an index is outside."""
    functions = names_of_functions("\n".join(path.read_text() for path in SOURCES))
    assert "cell_of" in functions and "n" in functions
    assert {path.name: found for path in SOURCES if (found := guessed_sections(path.read_text(), functions))} == {}


def names_of_contiguous(sources):
    """Procedures with a contiguous dummy, by their names, those of type-bound procedures and generic ones."""
    own = {name for name, body in re.findall(r"^ *(?:[\w()]+ )*(?:subroutine|function) (\w+)\((.*?)^ *end (?:subroutine|function)", sources, re.MULTILINE | re.DOTALL)
           if re.search(r"\bcontiguous\b[^!\n]*::", body)}
    bound = re.findall(r"(?:procedure|generic) *(?:, *\w+ *)*:: *(\w+) *=> *([\w, ]+)", sources)
    return own | {name for name, by in bound if own & set(re.findall(r"\w+", by))}


def transposed_arguments(source, procedures):
    """Lines that hand a transposed array to one of some procedures."""
    return [f"{number}: {opening[0]}" for number, code in (statements(source) if "transpose(" in source else ()) if "transpose(" in code and not re.match(r"(?:\w+ )*function ", code) for opening in OPENING.finditer(code)
            if re.findall(r"\w+", opening[0])[-1] in procedures and any(part.strip().startswith("transpose(") for part in parts_of(code[opening.end():])[0])]


def test_no_contiguous_dummy_is_given_a_transposed_array():
    """It has the wrong shape: of an expression with gfortran 12 to 14, of a section with 14 where the dummy is a target."""
    whole = "subroutine take(x)\n real, intent(in), contiguous, target :: x(:, :)\nend subroutine take\nprocedure :: give => take\ngeneric :: put => other, take\n"
    assert names_of_contiguous(whole) == {"take", "give", "put"}
    for line, count in (("call a%put(n, transpose(a(:n, :)))", 1), ("call take(matmul(transpose(a), b))", 0), ("call other(transpose(a))", 0)):
        assert len(transposed_arguments(line, {"take", "give", "put"})) == count
    procedures = names_of_contiguous("\n".join(path.read_text() for path in SOURCES))
    assert {"append_matrix", "append", "solve_mass"} < procedures
    assert {path.name: found for path in SOURCES if (found := transposed_arguments(path.read_text(), procedures))} == {}
