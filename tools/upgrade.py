#!/usr/bin/env python3
"""Print namelists and sweeps of versions 1 and 2 with the names that version 3 gives to groups' keys, to values and to columns.

    tools/upgrade.py case.nml                 prints it rewritten; comments and layout stay
    tools/upgrade.py --in-place *.nml *.yaml  writes the files that change
    tools/upgrade.py --columns                prints the new names of columns and attributes of results, as JSON

A file that is rewritten already stays as it is. Keys of which version 3 has nothing are left out of namelists and told, in sweeps they are told. Keys and values that these
tables do not have are not looked at: `hampm --check` does. docs/how-to/upgrading.md has what changes beside names.
"""

import argparse
import json
import os
import re
import runpy
import shutil
import sys
from pathlib import Path

# By its path: the package needs others, and this has to run where nothing is installed
NAMES = runpy.run_path(str(Path(__file__).resolve().parent.parent / "python/src/hampm/former_names.py"))
COLUMNS, ATTRIBUTES, KEYS, REMOVED, column, new_key = (NAMES[name] for name in ("COLUMNS", "ATTRIBUTES", "KEYS", "REMOVED", "column", "new_key"))
VALUES = {  # of keys by their new names
    ("material", "volumetric"): {"point": "standard", "cell": "b_bar"},
    ("contact", "bodies"): {"joined": "bonded"},
    ("method", "mass"): {"full": "consistent", "blend": "weighted"},
    ("method", "solver"): {"umfpack": "direct", "banded": "direct"},
    ("energy_release", "estimators"): NAMES["ESTIMATORS"],
}
ESTIMATORS = "energy_release", "estimators"
BALANCE = "energy_balance"  # an estimator of version 1, and now a key of its own
NEWLINE = re.compile(r"\r?\n")
MOST_TIPS = 20  # for which --columns prints names

TOKEN = re.compile(r"""(?P<comment>![^\r\n]*)|(?P<text>'(?:[^'\n]|'')*'?|"(?:[^"\n]|"")*"?)|(?P<group>&[ \t]*\w*)|(?P<end>/)"""
                   r"""|(?P<word>[^\s,/!='"&(%]+)|(?P<blank>\s+)|(?P<mark>.)""")


def main():
    options = parse()
    if options.columns:
        print(json.dumps(columns(), indent=1))
    try:
        for path in options.files:
            with open(path, encoding="utf-8", errors="surrogateescape", newline="") as file:
                text = file.read()
            new = upgraded(text, path.suffix in (".yaml", ".yml"), told := [])
            for words in told:
                print(f"upgrade.py: {path}: {words}", file=sys.stderr)
            if not options.in_place:
                sys.stdout.buffer.write(new.encode("utf-8", "surrogateescape"))
            elif new != text:
                replace(path, new)
    except OSError as error:
        sys.exit(f"upgrade.py: {error}")


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", metavar="FILE", nargs="*", type=Path, help="a namelist, or a sweep where its name ends in .yaml or .yml")
    parser.add_argument("--in-place", action="store_true", help="write the files")
    parser.add_argument("--columns", action="store_true", help="print the renamed columns and attributes")
    options = parser.parse_args()
    if not options.files and not options.columns:
        parser.error("a FILE is needed, or --columns")
    return options


def replace(path, text):
    """Write a file, whole or not at all."""
    path = path.resolve()
    beside = path.with_name(path.name + ".upgraded")
    beside.write_bytes(text.encode("utf-8", "surrogateescape"))
    shutil.copymode(path, beside)
    os.replace(beside, path)


def columns():
    """Old name -> new name of columns, of each tip, and of attributes."""
    tips = ("", *(f"_tip{n}" for n in range(2, MOST_TIPS + 1)))
    return {**{old + tip: new + tip for tip in tips for old, new in COLUMNS.items()}, **ATTRIBUTES}


def upgraded(text, is_sweep=False, told=None):
    """A namelist, or a sweep, with the names of version 3; `told` is a list to which is added what a user has to know."""
    return (upgraded_sweep if is_sweep else upgraded_namelist)(text, [] if told is None else told)


def new_value(group, key, text):
    """A value, without its quotes, as it is written now; the key by its new name."""
    new = VALUES.get((group, key), {}).get(text.strip().lower())
    return text if new is None else in_case_of(text, new)


def in_case_of(old, new):
    return new.upper() if old.isupper() else new


# Namelists: a list of tokens (kind, text), which together are the file.

def upgraded_namelist(text, told):
    tokens = [(found.lastgroup, found[0]) for found in TOKEN.finditer(text)]
    written, group, at = [], None, 0
    while at < len(tokens):
        kind, word = tokens[at]
        at += 1
        if kind == "group":
            group = word[1:].strip().lower()
        elif kind == "end":
            group = None
        elif kind == "word" and group is not None and is_key(tokens, at - 1):
            key, first = new_key(group, word.lower()), at
            while at < len(tokens) and tokens[at][0] not in ("group", "end") and not is_key(tokens, at):
                at += 1
            if (group, key) in REMOVED:
                told.append(f"&{group} {key} is left out: {REMOVED[group, key]}")
                written = without_key(written, tokens[first:at])
                continue
            values = [(kind, quoted_value(group, key, value) if kind == "text" else value) for kind, value in tokens[first:at]]
            name = word if key == word.lower() else in_case_of(word, key)
            if (group, key) == ESTIMATORS:
                written += with_balance(name, values, own_indent(written))
            else:
                written += with_comments_in_place([(kind, word), *tokens[first:at]], [("word", name), *values])
            continue
        written.append((kind, word))
    return "".join(word for _, word in written)


def is_key(tokens, at):
    """Whether a token is a word before `=`, `(` or `%`."""
    if tokens[at][0] != "word" or not tokens[at][1][0].isalpha():
        return False
    behind = next((word for kind, word in tokens[at + 1:at + 3] if kind != "blank"), "")
    return behind in ("=", "(", "%")


def without_key(written, behind):
    """What is written before a key that is left out, and what stands behind its value; a line that had nothing else goes."""
    last = max(k for k, (kind, _) in enumerate(behind) if kind not in ("blank", "comment")) + 1
    before, rest = "".join(word for _, word in written), "".join(word for _, word in behind[last:])
    end = re.match(r"[ \t]*(?:\r?\n)", rest)
    if end and own_indent(written) is not None:
        before, rest = before.rstrip(" \t"), rest[end.end():]
    elif before[-1:] in (" ", "\t"):
        rest = rest.lstrip(" \t")
    return [("word", before), ("word", rest)]


def quoted_value(group, key, text):
    """The same of a value with its quotes."""
    quote, value = text[0], text[1:].removesuffix(text[0])
    new = new_value(group, key, value)
    return text if new == value else quote + new + quote


def own_indent(written):
    """What stands before a key that begins a line; None for one that does not."""
    line = "".join(word for _, word in written).rpartition("\n")[2]
    return line if line.strip() == "" else None


def with_balance(name, values, indent):
    """A key of estimators and its values; the energy balance is taken out of them and set by its own key."""
    at = next((k for k, (kind, text) in enumerate(values) if kind == "text" and text[1:-1].strip().lower() == BALANCE), None)
    if at is None:
        return [("word", name), *values]
    setting = f"{in_case_of(name, BALANCE)} = .true."
    texts = [k for k, (kind, _) in enumerate(values) if kind == "text"]
    if len(texts) == 1:
        return [("word", setting), *values[at + 1:]]
    marks = [k for k, (_, text) in enumerate(values) if text == ","]
    comma = next((k for k in reversed(marks) if k < at), None) if at != texts[0] else next((k for k in marks if k > at), None)
    dropped = {at, comma}
    if comma is not None:
        between = range(min(comma, at) + 1, max(comma, at) + 1) if comma < at else range(at + 1, texts[1])
        dropped |= {k for k in between if values[k][0] == "blank"} if all(values[k][0] != "comment" for k in between) else set()
    kept = [token for k, token in enumerate(values) if k not in dropped]
    last = max(k for k, (kind, _) in enumerate(kept) if kind == "text") + 1
    behind = "".join(text for _, text in kept[last:])
    comment = re.match(r"[ \t]*(![^\r\n]*)?(?=\r?\n)", behind)
    if indent is None or not comment:
        return [("word", name), *kept[:last], ("word", f"  {setting}"), *kept[last:]]
    return [("word", name), *kept[:last], ("comment", comment[0] + NEWLINE.search(behind)[0] + indent + setting + behind[comment.end():])]


def with_comments_in_place(old, new):
    """Tokens with comments behind values of changed length moved back to their columns, as far as there is room."""
    shift, placed = 0, []
    for (kind, before), (_, after), (behind, _) in zip(old, new, [*old[1:], ("end", "")]):
        if kind == "blank" and "\n" in before:
            shift = 0
        elif kind == "blank" and behind == "comment":
            after = " " * max(1, len(before) - shift)
        shift += len(after) - len(before)
        placed.append((kind, after))
    return placed


# Sweeps: nodes with their places in the text, and a list of changes of parts of it.

class Node:
    """Part of a YAML text. `items` of a sequence, or (key, value) of a mapping; None of a scalar."""

    def __init__(self, start, end, items=None, kind="scalar", flow=False):
        self.start, self.end, self.items, self.kind, self.flow = start, end, items, kind, flow


class Yaml:
    """As much of YAML as sweeps have: mappings and sequences, in lines or in brackets, and scalars of one line."""

    SCALAR = re.compile(r"""'(?:[^']|'')*'|"(?:[^"\\]|\\.)*"|(?:[^\s#:]|:(?!\s|$)|(?<!\s)#|[ \t]+(?![\s#]))+""")
    IN_BRACKETS = re.compile(r"""'(?:[^']|'')*'|"(?:[^"\\]|\\.)*"|(?:[^\s#:,\[\]{}]|:(?![\s,\]}])|(?<!\s)#|[ \t]+(?![\s#,\]}]))+""")
    NOTHING = re.compile(r"(?:\s|(?:(?<=\s)|^)#[^\n]*)*", re.MULTILINE)
    COLON = re.compile(r"[ \t]*:(?=\s|$)")

    def __init__(self, text):
        self.text, self.at = text, 0

    def skip(self):
        self.at = self.NOTHING.match(self.text, self.at).end()
        return self.at < len(self.text)

    def column(self):
        return self.at - self.text.rfind("\n", 0, self.at) - 1

    def is_dash(self):
        return re.match(r"-(\s|$)", self.text[self.at:self.at + 2]) is not None

    def node(self, least):
        """The node that begins next, in this column or behind it; an empty one where nothing does."""
        start = self.at
        if not self.skip() or self.column() < least:
            return Node(start, start)
        if self.text[self.at] in "[{":
            return self.in_brackets()
        column, first = self.column(), self.at
        if self.is_dash():
            items = []
            while self.skip() and self.column() == column and self.is_dash():
                self.at += 1
                items.append(self.node(column + 1))
            return Node(first, items[-1].end, items, "sequence")
        node = self.scalar(self.SCALAR)
        if not self.COLON.match(self.text, self.at):
            return node
        pairs = []
        while True:
            self.at = self.COLON.match(self.text, self.at).end()
            here = self.at
            dashed = self.skip() and self.is_dash() and self.column() == column
            self.at = here
            pairs.append((node, self.node(column if dashed else column + 1)))
            if not self.skip() or self.column() != column or self.is_dash():
                break
            node = self.scalar(self.SCALAR)
            if not self.COLON.match(self.text, self.at):
                break
        return Node(first, pairs[-1][1].end, pairs, "mapping")

    def scalar(self, form):
        found = form.match(self.text, self.at)
        start, self.at = self.at, found.end() if found else self.at + 1
        return Node(start, self.at)

    def in_brackets(self):
        start, closing, items = self.at, {"[": "]", "{": "}"}[self.text[self.at]], []
        self.at += 1
        while self.skip() and self.text[self.at] != closing:
            if self.text[self.at] == ",":
                self.at += 1
                continue
            node = self.in_brackets() if self.text[self.at] in "[{" else self.scalar(self.IN_BRACKETS)
            if closing == "}":
                here = self.at
                if self.skip() and self.text[self.at] == ":":
                    self.at += 1
                    self.skip()
                    value = (Node(self.at, self.at) if self.text[self.at:self.at + 1] in (",", "}") else
                             self.in_brackets() if self.text[self.at:self.at + 1] in ("[", "{") else self.scalar(self.IN_BRACKETS))
                else:
                    self.at, value = here, Node(here, here)
                node = node, value
            items.append(node)
        self.at = min(self.at + 1, len(self.text))
        return Node(start, self.at, items, "sequence" if closing == "]" else "mapping", flow=True)


def upgraded_sweep(text, told):
    changes = []
    root = Yaml(text).node(0)
    for label, value in root.items if root.kind == "mapping" else ():
        name = scalar_of(text, label)
        told += [f"{group}.{key}: take it out, {REMOVED[group, key]}" for each in labels(name, value) for group, key in keys_of(text, each) if (group, key) in REMOVED]
        if name == "product" and value.kind == "mapping":
            for pair in value.items:
                change_axis(text, *pair, changes)
        elif name == "cases" and value.kind == "sequence":
            for case in value.items:
                for pair in case.items if case.kind == "mapping" else ():
                    change_setting(text, *pair, case.flow, changes)
        elif name == "columns":
            for scalar in scalars(value):
                old = text[scalar.start:scalar.end]
                changes.append((scalar.start, scalar.end, new_pattern(old)))
    for start, end, new in sorted(changes, reverse=True):
        text = text[:start] + new + text[end:]
    return text


def labels(name, value):
    """The keys of the product, or of the cases, of a sweep."""
    groups = {"product": [value], "cases": value.items or []}.get(name, [])
    return [label for group in groups if group.kind == "mapping" for label, _ in group.items]


def scalars(node):
    """The scalars of which a node consists, without keys."""
    if node.kind == "scalar":
        return [node]
    return [scalar for item in node.items for scalar in scalars(item[1] if isinstance(item, tuple) else item)]


def scalar_of(text, node):
    """A scalar without quotes."""
    word = text[node.start:node.end]
    return word[1:-1] if word[:1] in ("'", '"') else word.strip()


def new_pattern(pattern):
    """A column, perhaps with `*` and `?`, by its new name."""
    for old, new in VALUES[ESTIMATORS].items():
        pattern = re.sub(rf"\bG_{old}(?=[_*?]|\b)", f"G_{new.removesuffix('_integral')}", pattern)
    return re.sub(r"\b(J_spread|distance_from_rest)(?=_tip|[*?]|\b)", lambda found: column(found[1]), pattern)


def keys_of(text, label):
    """(group, key) of each of the keys that a label names, in lower case; without the numbers of groups."""
    words = [word.strip().lower() for word in scalar_of(text, label).split(",")]
    return [(re.sub(r"\(\d+\)$", "", word.partition(".")[0]), word.partition(".")[2]) for word in words]


def change_label(text, label, changes, added=""):
    word = text[label.start:label.end]
    new = re.sub(r"(\w+)(\(\d+\))?\.(\w+)", lambda found: found[0] if new_key(found[1].lower(), found[3].lower()) == found[3].lower() else
                 f"{found[1]}{found[2] or ''}.{new_key(found[1].lower(), found[3].lower())}", word)
    quote = word[0] if word[:1] in ("'", '"') else ""
    changes.append((label.start, label.end, new.removesuffix(quote) + added + quote if added else new))


def change_value(text, group, key, node, changes):
    """Write the names in a value anew. Returns whether the energy balance is taken out of it."""
    key, taken = new_key(group, key), False
    for scalar in scalars(node):
        old = text[scalar.start:scalar.end]
        new = re.sub(r"\w+", lambda found: new_value(group, key, found[0]), old) if (group, key) in VALUES else old
        if (group, key) == ESTIMATORS and re.search(rf"\b{BALANCE}\b", new, re.IGNORECASE):
            taken, new = True, without_balance(new)
        if new != old:
            changes.append((scalar.start, scalar.end, new))
    if taken and node.kind == "sequence":
        left = [new for scalar in node.items if (new := without_balance(re.sub(
            r"\w+", lambda found: new_value(group, key, found[0]), text[scalar.start:scalar.end]))) != '""']
        del changes[-sum(node.start <= start < node.end for start, _, _ in changes) or len(changes):]
        changes.append((node.start, node.end, f"[{', '.join(left)}]" if left else '""'))
    return taken


def without_balance(word):
    """A list of estimators in one text without the energy balance."""
    quote = word[0] if word[:1] in ("'", '"') and word[-1:] == word[0] else ""
    inner = word[1:-1] if quote else word
    left = [part for part in inner.split(",") if part.strip().strip("'\"").lower() != BALANCE]
    return (quote + ",".join(left).strip() + quote if quote else ",".join(left).strip()) if left else '""'


def change_setting(text, label, value, flow, changes):
    """One setting of a case."""
    change_label(text, label, changes)
    if not change_value(text, *keys_of(text, label)[0], value, changes):
        return
    place = re.sub(r"\w+$", BALANCE, scalar_of(text, label).lower())
    start = text.rfind("\n", 0, label.start) + 1
    indent = re.sub(r"[^\s]", " ", text[start:label.start])
    separator = ", " if flow else f"{NEWLINE.search(text)[0]}{indent}"
    changes.append((value.end, value.end, f"{separator}{place}: .true."))


def change_axis(text, label, rows, changes):
    """A key of the product, or keys that change together, and their values."""
    keys = keys_of(text, label)
    rows = rows.items if rows.kind == "sequence" else []
    values = [row.items if len(keys) > 1 and row.kind == "sequence" and len(row.items) == len(keys) else [row] for row in rows]
    taken = [False] * len(rows)
    for k, row in enumerate(values):
        for key, value in zip(keys, row if len(row) == len(keys) else []):
            taken[k] |= change_value(text, *key, value, changes)
    added = ""
    if any(taken):
        added = ", " + re.sub(r"\w+$", BALANCE, next(word.strip() for word in scalar_of(text, label).lower().split(",")
                                                      if word.strip().startswith(ESTIMATORS[0] + ".") and word.strip().endswith(ESTIMATORS[1])))
        for row, cells, flag in zip(rows, values, taken):
            if len(keys) == 1:
                changes.append((row.start, row.start, "["))
            changes.append((cells[-1].end, cells[-1].end, f", .{str(flag).lower()}.{']' if len(keys) == 1 else ''}"))
    change_label(text, label, changes, added)


if __name__ == "__main__":
    main()
