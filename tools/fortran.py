"""Reads what Fortran sources are made of: modules and what they use, procedures and their arguments, and which names mean which.

It knows free form as the sources of this program have it, not the whole language: no preprocessor, no `include`, no implicit types.
`read` gives a program, in which scopes (modules, procedures, types) hold each other; all names are in lower case.
"""

import re
from dataclasses import dataclass, field
from pathlib import Path

NUMBERS = "integer|real|logical|character|complex|double precision"
PREFIX = rf"(?:pure|impure|elemental|recursive|module|type|class|{NUMBERS})\b"
PROCEDURE = re.compile(rf"(?:{PREFIX}[\w\s(),*=:%]*?[\s)]\s*)?(subroutine|function)\s+(\w+)\s*(?:\(([^)]*)\))?"
                       r"\s*(?:(?:result|bind)\s*\(.*)?$")
USE = re.compile(r"use\b\s*(?:,\s*(\w+)\s*)?(?:::)?\s*(\w+)\s*(?:,\s*(only\s*:)?(.*))?$")
UNIT = re.compile(r"(module|program|submodule)\s*(?:\(\s*(\w+)[\w\s:]*\)\s*)?(\w+)$")
TYPE = re.compile(r"type\s*(?:,.*?)?(?:\bextends\s*\(\s*(\w+)\s*\).*?)?(?:::|\s)\s*(\w+)$")
END = re.compile(r"end\s*(?:(module|program|submodule|subroutine|function|procedure|type|interface)\b\s*.*)?$")
DECLARATION = re.compile(rf"(?:(?:{NUMBERS})\b|(?:type|class)\s*\(\s*(\w+|\*)\s*\)).*?::(.*)$")
BINDING = re.compile(r"(procedure|generic)\b.*?::(.*)$")
TOKEN = re.compile(r"\d[\w.]*|\w+|=>|==|/=|<=|>=|\S")


@dataclass(eq=False)
class Scope:
    """A module, program, procedure, derived type or interface, and what it holds."""

    kind: str
    name: str
    path: Path
    first: int                                     # line
    host: "Scope | None" = None
    last: int = 0
    arguments: list = field(default_factory=list)
    uses: list = field(default_factory=list)       # (module, None for all of it or {local name: name there})
    holds: dict = field(default_factory=dict)      # name: Scope, Variable or, of generic names and bindings, a list of names
    statements: list = field(default_factory=list)
    strings: list = field(default_factory=list)    # literals, without quotes
    extends: str = ""                              # of a type: the name of its parent

    def unit(self):
        """The module or program that it is in."""
        return self if self.host is None else self.host.unit()

    def title(self):
        """Its name behind those of what it is contained in, without the program's own prefix."""
        names = [self.name] if self.host is None else [self.host.title(), self.name]
        return ".".join(names).removeprefix("hampm_")

    def is_procedure(self):
        return self.kind in ("subroutine", "function")


@dataclass
class Variable:
    """A variable, argument or component; `of`: the name of its derived type; `alias`: what it is associated with."""

    of: str | None = None
    alias: tuple = ()


class Program:
    """All that some sources define."""

    def __init__(self, texts):
        """`texts`: path in the folder of the sources: text of each."""
        self.scopes = []
        for path, text in sorted(texts.items()):
            Reader(Path(path), self.scopes).read(text)
        self.modules = {scope.name: scope for scope in self.scopes if scope.host is None}
        self.procedures = [scope for scope in self.scopes if scope.is_procedure()]
        self.extending = [scope for scope in self.scopes if scope.extends]

    def imports(self):
        """Of each module or program those of these sources that it uses itself, in any of its procedures."""
        used = {scope.name: set() for scope in self.modules.values()}
        for scope in self.scopes:
            used[scope.unit().name] |= {module for module, _ in scope.uses if module in self.modules}
        return used

    def lookup(self, scope, name, seen=()):
        """What a name means in a scope, and the scope that holds it; None where that is not known."""
        while scope is not None:
            if name in scope.holds:
                return scope.holds[name], scope
            for module, names in scope.uses:
                there = name if names is None else names.get(name)
                if there and module in self.modules and (module, there) not in seen:
                    found = self.lookup(self.modules[module], there, (*seen, (module, there)))
                    if found:
                        return found
            scope = scope.host
        return None

    def type_of(self, scope, chain):
        """The derived type of a designator a%b%c, or None."""
        found = self.lookup(scope, chain[0])
        if not found or not isinstance(found[0], Variable):
            return None
        variable, holder = found
        for name in (*chain[1:], None):
            if variable.alias and variable.alias[0] != chain[0]:
                kind = self.type_of(scope, variable.alias)
            else:
                kind = (self.lookup(holder, variable.of) or [None])[0] if variable.of else None
            holder = next((one for one in self._line(kind) if isinstance(one.holds.get(name), Variable)), None)
            if name is None or holder is None:
                break
            variable = holder.holds[name]
        return kind if name is None else None

    def _line(self, kind):
        """A type and those that it extends, upwards."""
        while isinstance(kind, Scope) and kind.kind == "type":
            yield kind
            kind = (self.lookup(kind.host, kind.extends) or [None])[0]

    def meant(self, scope, chain):
        """The procedures that a designator names, which are several for a generic name and for a binding that types override; the
        second value is 1 for bindings, whose first argument stands before the %, else 0."""
        if len(chain) == 1:
            found = self.lookup(scope, chain[0])
            return (self._procedures(*found), 0) if found else ([], 0)
        kind, name = self.type_of(scope, chain[:-1]), chain[-1]
        if kind is None:
            return [], 0
        owners = [one for one in self._line(kind) if name in one.holds][:1]
        owners += [one for one in self.extending if one is not kind and name in one.holds and kind in self._line(one)]
        return [procedure for one in owners for procedure in self._procedures(one.holds[name], one)], 1

    def _procedures(self, what, scope):
        """The procedures of what a name stands for."""
        if isinstance(what, Scope):
            return [what] if what.is_procedure() else []
        if isinstance(what, Variable):
            return []
        found = []
        for name in what:
            other = scope.holds.get(name)
            is_binding = scope.kind == "type" and other is not what and other is not None
            again = (other, scope) if is_binding else self.lookup(scope.host or scope, name)
            found += self._procedures(*again) if again else []
        return found

    def calls(self, scope):
        """What the statements of a procedure or program itself refer to: (procedure, texts of actual arguments, shift) each."""
        for statement in scope.statements:
            for chain, actual in designators(statement):
                procedures, shift = self.meant(scope, chain)
                for procedure in procedures:
                    if procedure is not scope:
                        yield procedure, [".".join(chain[:-1])] * shift + actual


class Reader:
    """Reads one source into a list of scopes."""

    def __init__(self, path, scopes):
        self.path, self.scopes, self.scope = path, scopes, None

    def read(self, text):
        for line, statement, strings in statements(text):
            self.statement(line, re.sub(r"^\d+\s+", "", statement), strings)
            if self.scope:
                self.scope.strings += strings

    def open(self, kind, name, line, **more):
        scope = Scope(kind, name, self.path, line, self.scope, **more)
        self.scopes.append(scope)
        if self.scope is not None and "interface" not in (kind, self.scope.kind):
            self.scope.holds[name] = scope
        self.scope = scope

    def statement(self, line, text, strings):
        """Note what a statement says of the present scope, or open or close one."""
        if end := END.match(text):
            if self.scope is not None:
                self.scope.last = line
                self.scope = self.scope.host
        elif unit := UNIT.match(text) if self.scope is None else None:
            self.open(unit[1], unit[3], line, uses=[(unit[2], None)] if unit[2] else [])
        elif text.startswith(("interface", "abstract interface")) and re.match(r"(abstract )?interface(\s+\w+)?$", text):
            name = text.split()[-1] if text.startswith("interface ") else ""
            self.open("interface", name or "interface", line)
            if name:
                self.scope.host.holds[name] = []
        elif use := USE.match(text):
            self.use(use)
        elif procedure := PROCEDURE.match(text):
            arguments = [name.strip() for name in (procedure[3] or "").split(",") if name.strip()]
            kind = "foreign" if self.scope is not None and self.scope.kind == "interface" else procedure[1]
            self.open(kind, procedure[2], line, arguments=arguments)
            self.scope.holds |= {name: Variable() for name in (*arguments, *re.findall(r"result\s*\(\s*(\w+)", text))}
            if kind == "function":
                self.scope.holds.setdefault(procedure[2], Variable())
        elif type_ := TYPE.match(text):
            self.open("type", type_[2], line, extends=type_[1] or "")
        elif self.scope is not None:
            self.other(text)

    def use(self, use):
        if use[1] == "intrinsic" or self.scope is None:
            return
        renames = [[word.strip() for word in part.split("=>")] for part in top_level(use[4] or "") if part.strip()]
        names = {pair[0]: pair[-1] for pair in renames} if use[3] else None
        self.scope.uses.append((use[2], names))

    def other(self, text):
        """A declaration, a binding, an association or an executable statement."""
        scope = self.scope
        if declaration := DECLARATION.match(text):
            for item in top_level(declaration[2]):
                scope.holds[re.match(r"\s*(\w+)", item)[1]] = Variable(declaration[1])
        elif (binding := BINDING.match(text)) and scope.kind == "type":
            for item in [binding[2]] if binding[1] == "generic" else top_level(binding[2]):
                name, _, targets = (part.strip() for part in item.partition("=>"))
                if binding[1] == "procedure" and "pointer" in text.partition("::")[0]:
                    scope.holds[name] = Variable()
                else:
                    scope.holds.setdefault(name, []).extend(word.strip() for word in (targets or name).split(","))
            return
        elif scope.kind == "interface" and (names := re.match(r"(?:module )?procedure\s*(?:::)?\s*(.*)$", text)):
            if scope.name != "interface":
                scope.host.holds[scope.name] += [name.strip() for name in names[1].split(",")]
            return
        elif re.match(r"(\w+\s*:\s*)?associate\s*\(", text):
            for part in top_level(text[text.index("(") + 1:]):
                name, _, target = part.partition("=>")
                scope.holds[name.strip()] = Variable(alias=next((chain for chain, _ in designators(target)), ()))
        scope.statements.append(text)


def statements(text):
    """(line, statement, its literals) of a source: continued lines joined, lower case, no comments, literals without contents."""
    found, code, literals, quote, start = [], "", [], "", 0
    for number, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        if code:
            line = line.removeprefix("&")
        before = code
        for position, letter in enumerate(line):
            if quote and letter == "&" and not line[position + 1:].strip():
                break
            if quote:
                quote = "" if letter == quote else quote
                code += letter if not quote else ""
                literals[-1] += letter if quote else ""
            elif letter in "'\"":
                quote = letter
                code += letter
                literals.append("")
            elif letter == "!":
                break
            else:
                code += letter.lower()
        if not before.strip():
            start = number
        if quote or code.rstrip().endswith("&"):
            code = code.rstrip().removesuffix("&") + ("" if quote else " ")
            continue
        if before.strip() and not line.partition("!")[0].strip():
            continue  # a comment or an empty line between continued ones
        found += [(start, part.strip(), literals) for part in code.split(";") if part.strip()]
        code, literals = "", []
    return found


def top_level(text, separator=","):
    """The parts of a list, separated where no parenthesis is open."""
    parts, depth = [""], 0
    for letter in text:
        depth += (letter in "([") - (letter in ")]")
        if letter == separator and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return parts


def designators(statement):
    """What a statement names: (names of a%b(i)%c as a tuple, texts of the arguments in the last parentheses) each, but not names of
    keywords or of what stands alone left of an equals sign."""
    found, waiting, now = [], [], None
    tokens = [(match[0], match.start(), match.end()) for match in TOKEN.finditer(statement)]
    for k, (token, start, _) in enumerate(tokens):
        before, after = (tokens[k - 1][0] if k else ""), (tokens[k + 1][0] if k + 1 < len(tokens) else "")
        if token[0].isalpha() or token[0] == "_":
            if before == "%" and now is not None:
                found[now][0].append(token)
                found[now][1] = None
            else:
                is_named = before != "%" and after not in ("=", "=>")
                found.append([[token] if is_named else [], None])
                now = len(found) - 1 if is_named else None
        elif token == "(":
            waiting.append((now, start + 1))
            now = None
        elif token == ")" and waiting:
            now, begin = waiting.pop()
            if now is not None:
                found[now][1] = [part.strip() for part in top_level(statement[begin:start]) if part.strip()]
        elif token != "%":
            now = None
    return [(tuple(chain), actual or []) for chain, actual in found if chain]


def read(folder):
    """The program that the sources in a folder and those below it make."""
    return Program({path.relative_to(folder): path.read_text() for path in Path(folder).glob("**/*.f90")})
