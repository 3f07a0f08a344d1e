"""How the sources of src/ hang together, computed from their text alone.

    python tools/structure.py                              the report: lines, arguments, imports, longest files
    python tools/structure.py --svg FILE                   the picture of the folders and of what each uses
    python tools/structure.py --chain run take_step ...    the shortest chain of calls from one procedure to the next of these
    python tools/structure.py --velocity                   the files that one opens to follow a particle's velocity to G
    python tools/structure.py --walks                      files and depth of the five walks of CONTRIBUTING.md
    python tools/structure.py --walks 4                    the procedures of one, each below its caller, with file and what it does

--velocity counts the files on the shortest chains of calls from the start of the program to each procedure that names the velocity,
that is handed one, that names a column such as G_vcct_I, or whose own name then begins with `vcct`; and the files
whose modules declare a velocity (the key of `&body`, a component of a type). With --executed it leaves out procedures that the last
run of the coverage build did not enter: then it tells what a plain scene takes.

    make build=coverage program; rm -f build/coverage/*.gcda
    build/coverage/hampm input/dcb.nml --output results --force --set run.end_time=1e-4 --set output.snapshot_interval=0 \\
        --set energy_release.estimators=vcct
    python tools/structure.py --velocity --executed

Calls are references by name, type-bound ones by the declared type; of a generic name all procedures count. What is called through a
dummy procedure is not seen, but who hands the procedure on is.
"""

import argparse
import csv
import re
import sys
from collections import Counter, deque
from pathlib import Path

from fortran import read

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ROOT / "src"
FEW, MANY = 8, 12  # arguments
READING = (("main", "read_model", "fill_model"), ("main", "build", "fill_rectangle"))
RECORDING = (("main", "run.run", "recording.record", "measure", "tip_measurements.estimate_rates"), ("crack_closure.virtual_crack_closure",),
             ("main", "run.run", "recording.record", "results.append"))
STEPS = {  # from the loop of a run to where a step is done
    "in plain loops": (("run.advance_to_row", "reference_step.reference_step"),),
    "by particles": (("run.advance_to_row", "take_step", "step_in_tiles", "nodal_kernels.find_accelerations"),
                     ("run.advance_to_row", "take_step", "step_in_tiles", "particle_kernels.add_field"),
                     ("run.advance_to_row", "take_step", "step_in_stages", "particle_kernels.add_field")),
    "by operators of cells": (("run.advance_to_row", "take_step", "step_in_tiles", "nodal_kernels.find_accelerations"),
                              ("run.advance_to_row", "take_step", "step_in_tiles", "element_kernels.mass_by_lines"),
                              ("run.advance_to_row", "take_step", "step_in_stages", "element_kernels.mass_by_lines"))}
COLUMN = re.compile(r"G_(\w+)_I{0,2}$")
WALK = re.compile(r"^\| (\d)\. [^|]+ \| `(input/[\w/]+\.nml)` \| ([A-Z, ]+) \| (\d+) \| (\d+) \|$", re.MULTILINE)


# --- imports ----------------------------------------------------------------------------------------------------------

def reading_order(page):
    """Folders of src/ and files in src/ itself, in the order of the table under "Reading the code" in CONTRIBUTING.md."""
    cells = re.findall(r"^\| *(`src/[^|]*)\|", page.partition("## Reading the code")[2], re.MULTILINE)
    return [name.removeprefix("src/").rstrip("/") for cell in cells for name in re.findall(r"`([^`]+)`", cell)]


def rank(path, order):
    """Where a source stands in the order, the first being 0; files of src/ itself that no row begins with stand beside the last one
    that does."""
    place = path.parts[0]
    if len(path.parts) == 1 and place not in order:
        return max(k for k, name in enumerate(order) if name.endswith(".f90"))
    return order.index(place)


def upward_imports(program, order):
    """(module, module that it uses) where the used one stands above in the order."""
    modules = program.modules
    return [(name, used) for name, others in sorted(program.imports().items()) for used in sorted(others)
            if rank(modules[name].path, order) > rank(modules[used].path, order)]


def folder_of(path):
    """The folder of a source, "src" for those that are in none."""
    return path.parts[0] if len(path.parts) > 1 else "src"


def folder_imports(program):
    """How many uses of modules there are between folders, by (folder, used folder)."""
    counts = Counter((folder_of(program.modules[name].path), folder_of(program.modules[used].path))
                     for name, others in program.imports().items() for used in others)
    return {pair: n for pair, n in counts.items() if pair[0] != pair[1]}


def cycle(graph):
    """Names that need each other in a circle, or nothing; `graph`: name: those that it needs."""
    done, path = set(), []

    def visit(name):
        if name in path:
            return path[path.index(name):]
        if name not in done:
            path.append(name)
            for other in sorted(graph.get(name, ())):
                if found := visit(other):
                    return found
            done.add(path.pop())
        return []

    return next((found for name in sorted(graph) if (found := visit(name))), [])


def graph_of(pairs):
    """(name, name that it needs) ... as a graph."""
    graph = {}
    for name, other in pairs:
        graph.setdefault(name, set()).add(other)
    return graph


# --- calls ------------------------------------------------------------------------------------------------------------

class Calls:
    """Which procedures refer to which; `entered(scope)` tells which of them count."""

    def __init__(self, program, entered=lambda scope: True):
        self.program = program
        self.of = {scope: [(callee, actual) for callee, actual in program.calls(scope) if entered(callee)]
                   for scope in program.scopes if (scope.is_procedure() or scope.kind == "program") and entered(scope)}

    def find(self, name):
        """The procedure of a name such as `run` or `simulation.run`."""
        found = [scope for scope in self.of if ("." + scope.title()).endswith("." + name)]
        exact = [scope for scope in found if scope.title() == name]
        if len(exact or found) != 1:
            sys.exit(f"{name}: " + (", ".join(scope.title() for scope in found) or "no such procedure"))
        return (exact or found)[0]

    def shortest(self, start):
        """Of every procedure that `start` leads to the one before it on a shortest chain."""
        before, waiting = {start: None}, deque([start])
        while waiting:
            scope = waiting.popleft()
            for callee, _ in self.of[scope]:
                if callee not in before:
                    before[callee] = scope
                    waiting.append(callee)
        return before

    def chain(self, *points):
        """The shortest chain of procedures through some; empty where there is none."""
        whole = [points[0]]
        for start, end in zip(points, points[1:]):
            before = self.shortest(start)
            if end not in before:
                return []
            whole += chain_to(end, before)[1:]
        return whole


def chain_to(scope, before):
    """What leads to a procedure, from the first on."""
    return (chain_to(before[scope], before) if before[scope] else []) + [scope]


def handed(calls, word):
    """Of every procedure the dummy arguments that are given something of the name `word`, or a part of it, or such a dummy."""
    names = {scope: set() for scope in calls.of}
    waiting = deque(calls.of)
    while waiting:
        scope = waiting.popleft()
        known = names[scope] | {word}
        for callee, actual in calls.of[scope]:
            for k, text in enumerate(actual):
                key, _, value = text.rpartition("=") if re.match(r"\w+\s*=[^=]", text) else ("", "", text)
                value = re.sub(r"\s", "", value)
                while value != (value := re.sub(r"\([^()]*\)", "", value)):
                    pass
                dummy = key.strip() or (callee.arguments[k] if k < len(callee.arguments) else "")
                if dummy and value.split("%")[-1] in known and dummy not in names[callee]:
                    names[callee].add(dummy)
                    waiting.append(callee)
    return names


def walks(calls):
    """Of each way in which a step is done: the files from the namelist to G(t), and the depth of its calls below the loop of a run."""
    for way, steps in STEPS.items():
        chains = [calls.chain(*map(calls.find, points)) for points in (*READING, ("main", "run.advance_to_row"), *steps, *RECORDING)]
        yield way, {scope.path for chain in chains for scope in chain}, max(len(calls.chain(*map(calls.find, points))) - 1 for points in steps)


def written_walks(page, rows):
    """The walks that CONTRIBUTING.md has, of the rows of tools/walks.csv: (model, steps, files, depth) each; a step is (procedures, file, caller,
    name by which that calls them where they are bound at run time, file that binds them, what they do)."""
    tables = {}
    for table, *step in list(rows)[1:]:
        tables.setdefault(table, []).append(tuple(step))
    return [(model, [step for table in (*shared.split(", "), number) for step in tables[table]], int(files), int(depth))
            for number, model, shared, files, depth in WALK.findall(page.partition("### Five walks")[2].partition("\n## ")[0])]


def shown_walk(steps):
    """The lines of a walk: the steps that a procedure calls stand below it, in their order."""
    def below(callers, depth):
        for names, path, caller, _, _, what in steps:
            if caller in callers:
                yield f"{'  ' * depth + names.replace(' ', ', '):44} {path:40} {what}"
                yield from below(names.split(), depth + 1)
    return below([""], 0)


def walked(program, steps):
    """The files of a walk, and how many calls below the first step its deepest one is. Each caller is to be a step before, and to call what
    it calls, by no other procedures than those of its own file; else a ValueError tells where the walk is wrong."""
    scopes = {(str(scope.path), scope.name): scope for scope in reversed(program.scopes) if scope.is_procedure() or scope.kind == "program"}
    called = {}

    def calls_of(scope):
        if scope not in called:
            called[scope] = {callee for callee, _ in program.calls(scope)}
        return called[scope]

    def calls_between(caller, callee, binding):
        new, seen, n = {caller}, {caller}, 1
        while new:
            if any(callee in calls_of(scope) or binding and f"%{binding}(" in "".join(scope.statements).replace(" ", "") for scope in new):
                return n
            new = {other for scope in new for other in calls_of(scope) if other.path == caller.path} - seen
            seen, n = seen | new, n + 1
        raise ValueError(f"{caller.title()} does not call {callee.title()}")

    depth, at = {}, {}
    for names, path, caller, binding, binder, _ in steps:
        for name in names.split():
            if (scope := scopes.get((path, name))) is None:
                raise ValueError(f"src/{path}: there is no {name}")
            if at and caller not in at:
                raise ValueError(f"{name}: {caller or 'the caller'} is no step before it")
            if at.setdefault(name, scope) is not scope:
                raise ValueError(f"{name}: two steps have this name")
            if binder and not any(scope in calls_of(other) for other in scopes.values() if str(other.path) == binder):
                raise ValueError(f"src/{binder} does not bind {name}")
            depth[name] = depth[caller] + calls_between(at[caller], scope, binding) if caller else 0
    return {str(scope.path) for scope in at.values()} | {binder for *_, binder, _ in steps if binder}, max(depth.values())


def followed(calls, word="velocity"):
    """Of every file on the way of a quantity from the namelist to a column of G: why it is there."""
    mention = re.compile(rf"\b{word}\b")
    given = handed(calls, word)
    columns = {scope: found for scope in calls.of if (found := [name for name in map(COLUMN.match, scope.strings) if name])}
    estimators = tuple({name[1] for found in columns.values() for name in found})
    ends = {}
    for scope in calls.of:
        if scope in columns:
            ends[scope] = "names a column of G"
        elif scope.name.startswith(estimators):
            ends[scope] = "finds it"
        elif word in scope.strings or any(map(mention.search, scope.statements)):
            ends[scope] = f"names the {word}"
        elif given[scope]:
            ends[scope] = "is handed one"
    start = next(scope for scope in calls.of if scope.kind == "program")
    before = calls.shortest(start)
    why = {}
    for scope, reason in sorted(ends.items(), key=lambda item: (item[1], item[0].title())):
        if scope in before:
            why.setdefault(scope.path, f"{scope.name} {reason}")
    for scope in ends:
        for link in chain_to(scope, before) if scope in before else []:
            why.setdefault(link.path, "on the way there")
    for scope in calls.program.scopes:
        if scope.kind == "type" and word in scope.holds:
            why.setdefault(scope.path, f"{scope.name} has one")
        elif scope.kind == "module" and word in scope.strings:
            why.setdefault(scope.path, "lists the key")
    return why


def entered():
    """Whether a procedure was entered by what the coverage build ran, as a function."""
    from coverage import lines_run
    ran = {path: {line for line, count in counts.items() if count} for path, counts in lines_run().items()}
    return lambda scope: any(scope.first <= line <= scope.last for line in ran.get(str(Path("src") / scope.path), ()))


# --- report -----------------------------------------------------------------------------------------------------------

def report(program, order):
    """The report as lines of text."""
    lengths = {scope.path: 0 for scope in program.scopes}
    for path in lengths:
        lengths[path] = len((SOURCES / path).read_text().splitlines())
    folders = sorted({folder_of(path) for path in lengths}, key=lambda name: order.index(name) if name in order else -1)
    yield "folder         files  lines  procedures"
    for folder in [*folders, ""]:
        paths = [path for path in lengths if folder in ("", folder_of(path))]
        procedures = sum(scope.path in paths for scope in program.procedures)
        yield f"{folder or 'all':14} {len(paths):5} {sum(map(lengths.get, paths)):6} {procedures:11}"
    foreign = [scope for scope in program.scopes if scope.kind == "foreign"]
    for limit in (FEW, MANY):
        found = sorted((scope for scope in program.procedures if len(scope.arguments) > limit),
                       key=lambda scope: (-len(scope.arguments), scope.title()))
        libraries = sum(len(scope.arguments) > limit for scope in foreign)
        yield f"\nmore than {limit} arguments: {len(found)} procedures, and {libraries} of libraries"
        yield from (f"  {len(scope.arguments):3} {scope.title()}" for scope in found)
    pairs = folder_imports(program)
    yield "\nuses of modules of the folder of a column by the folder of a row"
    yield " " * 12 + "".join(f"{name[:8]:>9}" for name in folders)
    yield from (f"{name:12}" + "".join(f"{pairs.get((name, other), '.'):>9}" for other in folders) for name in folders)
    yield "\nagainst the order of CONTRIBUTING.md: " + (", ".join(map(" uses ".join, upward_imports(program, order))) or "none")
    for what, graph in (("modules", program.imports()), ("folders", graph_of(pairs))):
        yield f"cycle of {what}: " + (" > ".join(cycle(graph)) or "none")
    named = sum(bool(re.search(r"\bvelocity\b", (SOURCES / path).read_text(), re.IGNORECASE)) for path in lengths)
    yield f"\nfiles that name velocity: {named} of {len(lengths)}"
    yield "from the namelist to G(t): " + "; ".join(f"{len(files)} files where steps go {way}, {depth} calls deep"
                                                for way, files, depth in walks(Calls(program)))
    yield "\nlongest files"
    yield from (f"  {n:4} {path}" for path, n in sorted(lengths.items(), key=lambda item: -item[1])[:12])


def what_is_in(page):
    """Of each folder of src/ what the table of CONTRIBUTING.md says is in it, as far as a line of the picture holds."""
    rows = re.findall(r"^\| *`src/(\w+)/` *\| *([^|]*?) *\|", page.partition("## Reading the code")[2], re.MULTILINE)
    return {name: text if len(text) < 64 else re.match(r".{,64}(?=[;,])", text)[0] + ", ..." for name, text in rows}


def svg(program, order, meaning):
    """The picture of the folders in their order and of what each uses: dark arrows where no way over other folders leads there."""
    pairs = [pair for pair in folder_imports(program) if "src" not in pair]
    used = graph_of(pairs)
    rooms = [name for name in order if name in meaning]
    height, row, left, right = 30, 42, 20, 560
    top = {name: 20 + row * k for k, name in enumerate(rooms)}

    def reached(start):
        found, waiting = set(), list(used.get(start, ()))
        while waiting:
            if (name := waiting.pop()) not in found:
                found.add(name)
                waiting += used.get(name, ())
        return found

    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 860 {40 + row * len(rooms)}" font-family="sans-serif">',
             '<defs><marker id="end" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="9" markerHeight="9" markerUnits="userSpaceOnUse" orient="auto">'
             '<path d="M0 0 L8 4 L0 8 z" fill="#1f5fa8"/></marker></defs>', '<rect width="100%" height="100%" fill="#fff"/>']
    for a, b in sorted(pairs, key=lambda pair: (top[pair[1]] - top[pair[0]], pair)):
        is_direct = not any(b in reached(other) for other in used[a] if other != b)
        start, end = top[a] + height * 0.7, top[b] + height * 0.3
        bend = right + 30 + 270 * (top[b] - top[a]) / (row * len(rooms))
        style = 'stroke="#1f5fa8" marker-end="url(#end)" stroke-opacity="0.9"' if is_direct else 'stroke="#888" stroke-opacity="0.35"'
        parts.append(f'<path d="M{right} {start:.0f} C{bend:.0f} {start:.0f} {bend:.0f} {end:.0f} {right} {end:.0f}" fill="none" '
                     f'stroke-width="2" {style}><title>{a} uses {b}</title></path>')
    for name in rooms:
        parts += [f'<rect x="{left}" y="{top[name]}" width="{right - left}" height="{height}" rx="4" fill="#eef3f9" stroke="#1f5fa8"/>',
                  f'<text x="{left + 10}" y="{top[name] + 20}" font-size="15" font-weight="bold">{name}/</text>',
                  f'<text x="{left + 114}" y="{top[name] + 20}" font-size="13">{meaning[name]}</text>']
    return "\n".join([*parts, "</svg>", ""])


def titles(scopes):
    return [f"  {k:3} {scope.title():40} {scope.path}:{scope.first}" for k, scope in enumerate(scopes)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--svg", metavar="FILE", type=Path)
    parser.add_argument("--chain", metavar="PROCEDURE", nargs="+")
    parser.add_argument("--velocity", action="store_true")
    parser.add_argument("--executed", action="store_true")
    parser.add_argument("--walks", metavar="NUMBER", nargs="?", const=0, type=int, choices=range(6))
    options = parser.parse_args()
    program = read(SOURCES)
    page = (ROOT / "CONTRIBUTING.md").read_text()
    if options.svg:
        options.svg.write_text(svg(program, reading_order(page), what_is_in(page)))
    if options.chain or options.velocity:
        calls = Calls(program, entered() if options.executed else lambda scope: True)
    if options.chain:
        chain = calls.chain(*map(calls.find, options.chain))
        print(f"{' > '.join(options.chain)}: {len(chain) - 1} calls" if chain else "there is no such chain")
        print(*titles(chain), sep="\n")
    if options.velocity:
        why = followed(calls)
        print(f"from the velocity of a &body to G: {len(why)} files")
        print(*(f"  {path!s:36} {text}" for path, text in sorted(why.items())), sep="\n")
    if options.walks is not None:
        with open(ROOT / "tools/walks.csv", newline="", encoding="utf-8") as file:
            written = written_walks(page, csv.reader(file))
        for model, steps, *_ in written[options.walks - 1:options.walks] if options.walks else written:
            files, depth = walked(program, steps)
            print(f"{model}: {len(steps)} steps, {len(files)} files, {depth} calls deep", *(shown_walk(steps) if options.walks else ()), sep="\n")
    if not (options.svg or options.chain or options.velocity or options.walks is not None):
        print(*report(program, reading_order(page)), sep="\n")


if __name__ == "__main__":
    main()
