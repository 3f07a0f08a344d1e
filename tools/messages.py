#!/usr/bin/env python3
"""Write the page "I got this message" from the sources: how each message of the program begins, its cause and its remedy.

    python3 tools/messages.py > docs/reference/messages.md

A message is the text that a procedure of `CALLS` takes: literals, constants, and what a variable or function of the same file may be; an ellipsis
stands for the rest, as numbers and names. Its cause follows "Likely cause:" or a colon, its remedy a sentence that begins with a verb of `VERBS`;
`USUAL` has the remedies of messages that tell of none. Rules between keys are those of docs/reference/key_rules.md. It needs no packages.
"""

import re
import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from fortran import statements, top_level  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/reference/messages.md"
CALLS = {"errors%add": 0, "report": 1, "complain": 2, "complain_in_words": 2, "warn": 0, "warn_once": 1, "refuse": 0, "add_line": 1, "add_once": 1,
         "add": 1, "print_message": 0}  # which argument is the text
CALL = re.compile(r"\bcall (?:\w+%)*?(" + "|".join(CALLS) + r")\(")
OF_KEYS = "complain", "complain_in_words"  # which take the key of a group before the text
KINDS = {"exit_input": "input", "exit_computation": "stop", "exit_file": "file", "exit_stopped": "stop"}
TITLES = {
    "stop": ("A run ends", "Exit code 3: the computation failed. The message names step, time and place. Results up to there are kept."),
    "warning": ("A run goes on, and warns", "Exit code 0. The numbers may mean something else than you think."),
    "file": ("A file cannot be read or written", "Exit code 4."),
    "input": ("A model or a command line is refused", "Exit code 2. A message begins with file, line, group and key, `case.nml:12: &grid cell = 0.1:`;\n"
              "here with the key. All errors are reported at once.")}
VERBS = ("add allow ask begin build choose end fix give hold increase install keep leave let load look make move name put raise record reduce refine remove "
         "resume run see set shorten smaller take try use write").split()
REMEDY = re.compile(r"(?:^|(?:[;:.,](?: or)?|\)) +)((?:" + "|".join(VERBS) + r")\b.*)", re.IGNORECASE)
GAP, LEAST, DEEPEST, WAYS = "…", 13, 3, 8  # letters of a message; names in names; texts that one call may have
FIRST, SHARED = 16, 3  # words of a message on the page; messages with one cause and remedy, which the page then says once
USUAL = [  # what a message contains, a cause and a remedy, where it tells of none itself
    ("cannot be resumed", "the checkpoint is damaged, or of another version", "resume an older checkpoint by the same program, or begin anew"),
    ("the tip the strain", "strain is large there", "use J, not K, and a law for large strain"),
    ("not enough memory|are too many", "the model is too large for this machine", "use fewer cells, levels or particles, or a machine with more memory"),
    ("energy has grown|no longer a number|or no longer", "the step is beyond its limit, or a load is too sudden or too large",
     "leave `&method courant` at 0, or reduce it or `time_step`; look at the last snapshot near this place"),
    ("most_time|is not reached", "the error that is asked needs more than the limits allow", "raise the limits, or ask for a larger error"),
    ("has no modes", "contact, friction, cohesion, damping or another law", "use a linear law without these, or `time = 'implicit'`"),
    ("modes|ARPACK|too few nodes that move", "more modes are asked than the cells have, or a part is loose", "ask for fewer `modes`, use more cells, or hold the part"),
    ("CHOLMOD has its settings", "hampm was built with another SuiteSparse", "build it anew: `make setup`, `make program`"),
    ("CHOLMOD|UMFPACK|positive definite|factorised", "a part is held too little, cells hold too few particles, or memory does not suffice",
     "hold each part by a &constraint, use more particles a cell, or `solver = 'cg'` for less memory"),
    ("conjugate gradients|solved with", "the matrix is nearly singular", "use `solver = 'direct'`"),
    ("no factor of the loads|held loads or eigenstrains", "held loads open the crack", "let loads that are scaled open the crack, or hold less of them"),
    ("load frame", "the load that is scaled does not move the place of the frame", "let it act where the frame measures"),
    ("a piece that nothing else holds", "faces do not press on each other", "hold the piece by a &constraint, or use `time = 'explicit'`"),
    ("contact state", "faces or supports open and close in turn", "use more `load_steps`, or other cells"),
    ("equilibri", "the loads are beyond a limit load, or a load step is too long", "use more `load_steps`; `time = 'explicit'` follows the motion beyond"),
    ("law of growth is not for such K", "units of the law", "give `rate_constant` for K in Pa m^0.5 and ways in m, or reduce the loads"),
    ("K_II", "increments are long for the curvature of the path", "use shorter increments and smaller cells at the tip"),
    ("waited|no longer grows", "its G stays below its toughness", "give loads that open this tip, or leave it out of &growth"),
    ("runs by itself", "growth is not stable at these loads", "nothing to mend; `time = 'implicit'` or `'explicit'` follows it in motion"),
    ("starts at t =", "cells are coarse for the rise of the load", "use smaller cells at the tip, or a slower rise"),
    ("nearer than one of the finest", "the tip is at the end of its crack", "use smaller cells there; values before are valid"),
    ("history begins|may pass|its factor", "the history and the steps do not fit", "use shorter steps, another history or another end of the run"),
    ("done no work", "loads cancel, or act on held places", "look at loads, constraints and histories by `--check`"),
    ("displacement gradient", "strains or rotations are large", "use a law for large strain"),
    ("disk full|cannot be written|be made|Is a directory", "the disk is full, or the folder read-only", "make room, or give another folder with `--output`"),
    ("another model than the checkpoint", "files of two runs are in one folder", "put the checkpoint beside its own result"),
    ("cannot be read", "the name is wrong, or the file may not be read", "correct the name"),
    ("stopped by", "you, the system or a limit ended it", "go on by `--resume`"),
    ("--force|--resume|another file", "an earlier run is in the folder", "give the option that is named, or another folder with `--output`"),
    ("ends before|eparated|fracture|has met|arrest|ends there|has come to|is new", "the model has come to this end", "nothing to mend"),
    ("point load", "a point load has no limit of its displacement", "give a traction on a part of an edge, or measure some cells away"),
    ("large; lengths|waves would pass", "units: m, Pa, kg/m3", "give lengths in m, moduli in Pa, densities in kg/m3"),
    ("start is", "it begins after the end of the run", "let it start earlier, or the run end later"),
    ("none is a tip|no tip", "no end of a crack is inside the material", "move the points of the crack"),
    ("holds no node", "its box is beside the material", "move or widen the box"),
    ("points_per_cell = 1", "one particle a cell does not resolve the tip", "use 2 or more, or the estimator 'domain_integral'"),
    ("in a row", "the crack runs through a row of particles", "move it by the distance that is told, or leave it"),
    ("they are bonded|about a cell apart", "bodies share the nodes of the grid", "use &contact, or a &crack along the seam, where they should part"),
    ("more than &body points_per_cell", "particles on grid lines have the strain of one cell only", "nothing to mend"),
    ("too narrow|steps of", "cells or steps are too large for it", "use smaller cells, or shorter steps")]
OF_INPUT = [("missing|no value|closing|stands|twice|second time|begins another|no namelist|no text", "the file is not written so",
             "mend this place of the file; `hampm --template` shows every group"),
            ("no such|there is no|unknown|the name", "the name is not there", "correct the name; the message lists names"),
            ("--|argument|namelist file", "the command line", "`hampm --help` lists the options"),
            ("", "the value is another", "give such a value; `--check` tries it")]


@dataclass(frozen=True)
class Message:
    """kind: a key of TITLES; begins, cause, remedy: texts."""

    kind: str
    begins: str
    cause: str
    remedy: str

    @property
    def ending(self):
        """Cause and remedy, which messages may share; of a remedy of `OF_INPUT` with a cause of its own the remedy alone."""
        own = self.kind == "input" and any(self.remedy == row[2] and self.cause != row[1] for row in OF_INPUT)
        return "" if own else self.cause.lower(), self.remedy.lower()


class Source:
    """A file: its statements, each with its literals, and the expressions that a name may stand for."""

    def __init__(self, text):
        self.statements, self.values, scope = [], {}, ""
        for _, code, literals in statements(text):
            if match := re.match(r"(?!end )(?:[\w()=:* ,]*\b)?(?:subroutine|function) (\w+)", code):
                scope = match[1]
            self.statements.append((scope, code, literals))
            if "parameter ::" in code:
                for part in top_level(code.partition("::")[2]):
                    name, _, value = part.partition("=")
                    own, literals = literals[:value.count("''")], literals[value.count("''"):]
                    self.values.setdefault(("", name.strip()), []).append((value.strip(), own))
            elif match := re.match(r"(?:if \(.*\) +)?([a-z]\w*) = (.*''.*)", code):
                self.values.setdefault((scope, match[1]), []).append((match[2].strip(), literals[len(literals) - match[2].count("''"):]))

    def texts(self, expression, literals, scope, depth=0):
        """What an expression of characters in a procedure may be, with gaps."""
        found, literals = [""], list(literals)
        for part in top_level(expression.replace("//", "\0"), "\0"):
            own, literals = literals[:part.count("''")], literals[part.count("''"):]
            found = [a + b for a in found for b in self.part(part.strip(), own, scope, depth)][:WAYS]
        return found

    def part(self, part, own, scope, depth):
        """What a part of an expression, between two //, may be."""
        if re.fullmatch(r"('')+", part):
            return ["'".join(own)]
        if match := re.match(r"(?:trim\()?merge\(((?:'')+), *((?:'')+),", part):
            n = len(match[1]) // 2
            return [re.sub(" +$", "", "'".join(some)) for some in (own[:n], own[n:n + len(match[2]) // 2])]
        name = re.match(r"(?:trim\()?(\w+)", part)
        if name and depth < DEEPEST and "%" not in part:
            places = [place for place in ((scope, name[1]), (name[1], name[1]), ("", name[1])) if place in self.values][:1]
            texts = [text for place in places for value, literals in self.values[place] if not re.match(rf"{name[1]}\b", value)
                     for text in self.texts(value, literals, place[0] or scope, depth + 1)]
            grows = any(re.match(rf"{name[1]}\b *//", value) for place in places for value, _ in self.values[place])
            if texts := [text + GAP * grows for text in dict.fromkeys(texts) if text.strip()]:
                return texts
        return [GAP]

    def messages(self):
        """(procedure that is called, its arguments before the text, their literals, text) of all messages."""
        for scope, code, literals in self.statements:
            if match := re.match(r"(?:if \(.*\) +)?message = (.*''.*)", code):
                for text in self.texts(match[1], literals[code[:match.start(1)].count("''"):], scope):
                    yield "message", [], [], text
            if not (call := CALL.search(code)):
                continue
            literals, place = literals[code[:call.end()].count("''"):], CALLS[call[1]]
            arguments = top_level(code[call.end():].rstrip()[:-1])
            if len(arguments) <= place:
                continue
            own = [self.texts(arguments[k], literals[sum(a.count("''") for a in arguments[:k]):], scope)[0].strip() for k in range(place)]
            for text in self.texts(arguments[place], literals[sum(a.count("''") for a in arguments[:place]):], scope):
                yield call[1], arguments[:place], own, text


def parts(text, kind):
    """How a message begins, its cause and its remedy."""
    begins, _, cause = text.partition("Likely cause: ")
    if not cause:
        places = [match.start() for match in re.finditer(": ", text) if text[:match.start()].count("(") == text[:match.start()].count(")")]
        place = next((place for place in places if place >= LEAST and not text[:place].endswith("cannot be resumed")), len(text))
        begins, cause = text[:place], text[place + 2:]
        if re.match(rf"({GAP} )?--", cause):
            begins, cause = text, ""
    remedy = ""
    for k, part in enumerate([cause, begins]):
        if (match := REMEDY.search(part)) and (k == 0 or match.start()):
            remedy, rest = match[1], part[:match.start()]
            begins, cause = (begins, rest) if k == 0 else (rest, cause)
            break
    begins, cause, remedy = (part.strip(" .;:,") for part in (begins, cause, remedy))
    if not (remedy and re.search("[a-z]", cause)):
        usual = next((row for row in (OF_INPUT if kind == "input" else USUAL) if re.search(row[0], text)), None)
        if not usual:
            sys.exit(f"no remedy for a message: give USUAL of {__file__} a row for: {text}")
        cause, remedy = cause if re.search("[a-z]", cause) else usual[1], remedy or usual[2]
    return begins, cause, remedy


def found_in(path):
    """The messages of a source file."""
    for name, before, own, text in Source(path.read_text(encoding="utf-8")).messages():
        kind = {"message": "input" if path.parent.name == "input" else "stop"}.get(name, "warning")
        if name == "report":
            kind = next((kind for code, kind in KINDS.items() if code in before[0]), "stop")
        elif name == "refuse":
            kind, text = "file", "cannot be resumed: " + text
        elif name in OF_KEYS or name == "errors%add":
            kind, text = "input", (f"`{own[1]}`: {text}" if name in OF_KEYS and own[1] != GAP else text)
        text = re.sub(rf"({GAP} ?)+", f"{GAP} ", " ".join(text.replace("''", "'").split())).strip()
        text = re.sub(rf"{GAP} (?=['),.:;])", GAP, text)
        text = re.sub(r"(.{12,}?)\1+", r"\1", text)  # of a text that is put before itself
        if len(re.sub(r"[^a-z]", "", text)) >= LEAST and not re.match(rf"({GAP} )?(or|and|when|its G|nothing opens)\b", text):
            yield Message(kind, *parts(text, kind))


def all_messages():
    """The messages of all sources, each once, by kind and first words."""
    found = {}
    for path in sorted((ROOT / "src").rglob("*.f90")):
        for message in found_in(path):
            found.setdefault((message.kind, message.begins), message)
    return sorted(found.values(), key=lambda m: (list(TITLES).index(m.kind), re.sub(r"[^a-z]", "", m.begins.lower())))


def shortened(text):
    """The first words of a message, by which it is found."""
    return text if len(text.split()) <= FIRST else " ".join(text.split()[:FIRST]).rstrip(",;:.…") + GAP


def cell(text):
    """A text as a cell of a table: no sign of it is one of Markdown."""
    return re.sub(r"(`[^`]*`)|([|*<_\[\]$])", lambda match: match[1].replace("|", r"\|") if match[1] else "\\" + match[2], text)


def page():
    """The page as Markdown."""
    messages = all_messages()
    lines = ["# Messages: I got this message", "",
             f"Search this page for the first words of your message: it has {len(messages)} messages with cause and remedy. An ellipsis stands",
             "for numbers and names. `tools/messages.py` writes the page from the sources. Two kinds of messages have other pages:", "",
             "- `&a b = ... requires ...`, `is not allowed with`, `has no effect`: [rules between keys](key_rules.md);",
             "- a value outside of its range, or not among its choices: [keys](keys.md). [Places](places.md) has the reasons.", ""]
    for kind, (title, about) in TITLES.items():
        of_kind = [m for m in messages if m.kind == kind]
        shared = {ending for ending, number in Counter(m.ending for m in of_kind).items() if number >= SHARED}
        lines += [f"## {title}", "", about, "", "| the message begins | cause | remedy |", "|---|---|---|"]
        lines += [f"| {cell(shortened(m.begins))} | {cell(m.cause)} | {cell(m.remedy)} |" for m in of_kind if m.ending not in shared]
        for ending in sorted(shared):
            rows = [m for m in of_kind if m.ending == ending]
            said = ". ".join(part[:1].upper() + part[1:] for part in (ending[0] and rows[0].cause, rows[0].remedy) if part)
            lines += ["", f"| {cell(said)}: |" + " cause |" * (not ending[0]), "|---|" + "---|" * (not ending[0])]
            lines += [f"| {cell(shortened(m.begins))} |" + f" {cell(m.cause)} |" * (not ending[0]) for m in rows]
        lines.append("")
    return "\n".join(lines)


if __name__ == "__main__":
    print(page(), end="")
