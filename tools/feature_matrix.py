"""Which features of hampm are allowed together, by the table of rules that the program validates models with.

    python tools/feature_matrix.py                     print the matrix
    python tools/feature_matrix.py --write PAGE.md     put it into a page, between its marks

A feature is a part of a model: groups that are there, keys with one of some values, conditions of the table of rules with a name. Two
features are put together; then what the rules require is added and what they exclude is taken away, until nothing changes. Where no
value is left for a key the two are not allowed together: "not yet" where one of the rules on the way says that something is not
built, else "no". "no" also stands for two values of one key. What no rule decides is "yes"; places and numbers are not looked at.
"""

import argparse
import functools
import json
import os
import re
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PROGRAM = ROOT / os.environ.get("HAMPM", "build/release/hampm")
BEGIN, END = "<!-- feature matrix -->", "<!-- end of feature matrix -->"
YES, NO, NOT_YET = "yes", "**no**", "*not yet*"

# A short name: the condition that the model then fulfils, words of the table of rules joined by `and`
COLUMNS = {
    "explicit": "&method time = 'explicit' and a mass matrix that acts",
    "implicit": "&method time = 'implicit' and a mass matrix that acts",
    "modes": "&method time = 'modal' and a mass matrix that acts",
    "static": "&method time = 'static'",
    "total frame": "&method frame = 'total'",
    "updated frame": "&method frame = 'updated'",
    "quadratic": "&grid order = 2",
    "refined": "&refine indicator = 'tip' | 'zz' | 'gradient'",
    "face contact": "&crack and &crack kind = 'line' | 'path' and &crack contact = 'frictionless' | 'friction'",
    "cohesion": "&crack and &cohesive",
    "static growth": "&crack and &growth and &growth law = 'quasi_static' and &method time = 'static'",
    "dynamic growth": "&crack and &growth and &growth law = 'prescribed' | 'toughness' and &method time = 'explicit' | 'implicit'",
    "body contact": "&contact bodies = 'stick' | 'frictionless' | 'friction' and several bodies",
}
TABLES = {
    "Time, cells and bodies": {
        "axisymmetric": "&run plane = 'axisymmetric'",
        "quadratic cells": COLUMNS["quadratic"],
        "CPDI domains": "&method shape_functions = 'cpdi'",
        "refinement around tips": "&refine indicator = 'tip'",
        "refinement by error (zz)": "&refine indicator = 'zz'",
        "refinement by gradients": "&refine indicator = 'gradient'",
        "mass: lumped": "&method mass = 'lumped'",
        "mass: consistent": "&method mass = 'consistent'",
        "mass: weighted": "&method mass = 'weighted'",
        "mass: fmpm": "&method mass = 'fmpm'",
        "polygons, circles, holes": "edges that are no grid lines and cells that are cut",
        "contact of bodies": COLUMNS["body contact"],
        "unilateral supports": "&constraint unilateral = .true.",
        "moving supports": "&constraint velocity",
        "eigenstrain": "&body eigenstrain",
        "graded bodies": "&body profile_at",
    },
    "Materials": {
        "linear elastic": "&material law = 'linear_elastic'",
        "orthotropic": "&material law = 'orthotropic'",
        "neo-Hookean": "&material law = 'neo_hookean'",
        "Mooney-Rivlin": "&material law = 'mooney_rivlin'",
        "J2 plastic": "&material law = 'j2_plastic'",
        "viscoelastic": "&material law = 'viscoelastic'",
        "B-bar": "&material volumetric = 'b_bar'",
    },
    "Cracks, growth and estimators": {
        "crack on a symmetry plane": "&crack and &crack kind = 'symmetry'",
        "straight crack": "&crack and &crack kind = 'line'",
        "polyline crack": "&crack and &crack kind = 'path'",
        "several cracks": "&crack and several cracks",
        "faces: frictionless": "&crack and &crack contact = 'frictionless'",
        "faces: friction": "&crack and &crack contact = 'friction'",
        "cohesion": COLUMNS["cohesion"],
        "growth: straight": "&crack and &growth and &growth direction = 'straight'",
        "growth: hoop stress": "&crack and &growth and &growth direction = 'hoop_stress'",
        "growth: local symmetry": "&crack and &growth and &growth direction = 'local_symmetry'",
        "growth: given path": "&crack and &growth and &growth direction = 'path'",
        "growth in load cycles": "&crack and &growth and &growth law = 'fatigue'",
        "growth in time": "&crack and &growth and &growth law = 'subcritical'",
        "a crack that appears": "&crack and &nucleation",
        "domain integral": "&crack and &energy_release estimators = 'domain_integral'",
        "T-stress": "&crack and &energy_release t_stress = .true.",
        "K of an interface": "&crack and &energy_release phase_length",
        "VCCT": "&crack and &energy_release estimators = 'vcct'",
        "material forces": "&crack and &energy_release estimators = 'material_force'",
        "stress closure": "&crack and &energy_release estimators = 'stress_closure'",
        "energy balance": "&crack and &energy_release energy_balance = .true.",
    },
}
LISTS = {("energy_release", "estimators")}  # keys with several values at a time: one value leaves the others open


@dataclass
class Model:
    """What is known of a model: the values that a key may have, and facts that are true (groups, keys that are given, named features)."""

    values: dict = field(default_factory=dict)
    facts: set = field(default_factory=set)
    by_not_built: set = field(default_factory=set)  # keys and facts that follow from a rule whose reason is that something is not built


class Contradiction(Exception):
    """Nothing is left that a key may be, or two facts exclude each other."""


class Rules:
    """The table of rules, and the choices of the keys."""

    def __init__(self, rules, keys):
        self.rules = [rule for rule in rules if rule["verdict"] in ("not allowed with", "requires")]
        self.always = {group["group"] for group in keys if group["required"] or group["assumed"]}
        self.choices = {(group["group"], key["key"]): frozenset(key["choices"]) for group in keys for key in group["keys"] if key.get("choices")}

    @staticmethod
    @functools.cache
    def atom(text):
        """(group, key, comparison, values) of a condition's word; group alone, or key without values; of a named feature ("", text, "", ())."""
        match = re.fullmatch(r"&(\w+)(?: (\w+)(?: (=|/=|<|>) (.+))?)?", text.strip())
        if not match:
            return "", text.strip(), "", frozenset()
        group, key, comparison, values = match.groups()
        return group, key or "", comparison or "", frozenset(value.strip().strip("'") for value in (values or "").split("|") if value.strip())

    def possible(self, model, place):
        """The values that a key may have in a model; None where any number or text."""
        return model.values.get(place, self.choices.get(place))

    def is_there(self, model, group):
        """Whether a model is known to have a group."""
        return group in self.always or f"&{group}" in model.facts

    def holds(self, model, text):
        """Whether a word of a condition is true (True), false (False), or open (None)."""
        group, key, comparison, values = self.atom(text)
        if not group or not key or not comparison:
            return True if text.strip() in model.facts else None
        if (group, key) in LISTS:
            return True if values & model.values.get((group, key), frozenset()) else None
        left = self.possible(model, (group, key))
        if comparison in "<>" or left is None or not self.is_there(model, group):
            return None
        verdict = True if left <= values else False if not left & values else None
        return verdict if comparison == "=" or verdict is None else not verdict

    def condition(self, model, text):
        """The same of a condition."""
        def joined(parts, first):
            verdicts = [part for part in parts if part is not True] if first is False else list(parts)
            return first if first in verdicts else None if None in verdicts else not first
        return joined([joined([self.holds(model, word) for word in part.split(" and ")], False) for part in text.split(" or ")], True)

    def require(self, model, text):
        """Add to a model that a word is true; whether that is new."""
        group, key, comparison, values = self.atom(text)
        if group:
            model.facts.add(f"&{group}")
        if (group, key) in LISTS:
            known = model.values.get((group, key), frozenset())
            model.values[group, key] = known | values
            return not values <= known
        if comparison == "=":
            left = self.possible(model, (group, key))
            new = values if left is None else left & values
        elif comparison == "/=" and (group, key) in self.choices:
            left = self.possible(model, (group, key))
            new = left - values
        else:
            is_new = text.strip() not in model.facts
            model.facts.add(text.strip())
            return is_new
        model.values[group, key] = new
        if not new:
            raise Contradiction
        return new != left

    def exclude(self, model, text):
        """Add to a model that a word is false, as far as one word can say so; whether that is new."""
        group, key, comparison, values = self.atom(text)
        if comparison not in ("=", "/=") or (group, key) in LISTS or (group, key) not in self.choices:
            if text.strip() in model.facts:
                raise Contradiction
            return False
        if not self.is_there(model, group):
            return False
        rest = self.choices[group, key] - values if comparison == "=" else values
        return self.require(model, f"&{group} {key} = " + " | ".join(sorted(rest)))

    def verdict(self, *features):
        """What the rules say of features together."""
        model = Model()
        try:
            for feature in features:
                for word in feature.split(" and "):
                    self.require(model, word)
        except Contradiction:
            return NO
        is_new = True
        while is_new:
            is_new = False
            for rule in self.rules:
                try:
                    changed = self.apply(model, rule)
                except Contradiction:
                    return NOT_YET if self.is_by_not_built(model, rule) else NO
                if changed:
                    is_new = True
                    model.by_not_built |= changed if self.is_by_not_built(model, rule) else set()
        return YES

    def is_by_not_built(self, model, rule):
        """Whether what a rule says of a model comes of something that is not built."""
        known = [self.place(word) for text in (rule["subject"], rule["other"]) for word in re.split(" and | or ", text)]
        return rule["basis"] == "not built" or not model.by_not_built.isdisjoint(known)

    def place(self, text):
        """What a word of a condition is about: a key, a group or a named feature."""
        group, key, _, _ = self.atom(text)
        return (group, key)

    def apply(self, model, rule):
        """Add what follows from a rule; the keys and facts that are new."""
        subject, other = rule["subject"], rule["other"]
        if rule["verdict"] == "requires":
            if self.condition(model, subject) is not True or " or " in other or self.condition(model, other) is True:
                return set()
            return {self.place(word) for word in other.split(" and ") if self.holds(model, word) is not True and self.require(model, word)}
        words = [*subject.split(" and "), *other.split(" and ")]
        if " or " in subject + other:
            if self.condition(model, subject) is True and self.condition(model, other) is True:
                raise Contradiction
            return set()
        open_words = [word for word in words if self.holds(model, word) is not True]
        if not open_words:
            raise Contradiction
        if len(open_words) == 1 and self.holds(model, open_words[0]) is None and self.exclude(model, open_words[0]):
            return {self.place(open_words[0])}
        return set()


def of_program(program=PROGRAM):
    """The rules of the program."""
    return Rules(*(json.loads(subprocess.run([program, option, "--json"], capture_output=True, text=True, check=True).stdout)
                   for option in ("--rules", "--keys")))


def matrix(rules):
    """The matrix as lines of Markdown: a table for each part. Features with the same verdicts share a row, and yes is a blank."""
    for title, rows in TABLES.items():
        yield f"**{title}**"
        yield ""
        yield "| | " + " | ".join(COLUMNS) + " |"
        yield "|---|" + "---|" * len(COLUMNS)
        alike = {}
        for name, feature in rows.items():
            alike.setdefault(tuple(rules.verdict(feature, column).replace(YES, "") for column in COLUMNS.values()), []).append(name)
        for verdicts, names in alike.items():
            yield f"| {', '.join(names)} | " + " | ".join(verdicts) + " |"
        yield ""


def with_matrix(page, lines):
    """A page with the matrix between its marks."""
    return re.sub(f"(?<={re.escape(BEGIN)}\n).*?(?={re.escape(END)})", lambda _: "\n" + "\n".join(lines), page, flags=re.DOTALL)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", metavar="PAGE.md", type=Path)
    options = parser.parse_args()
    lines = list(matrix(of_program()))
    if not options.write:
        sys.exit(print(*lines, sep="\n"))
    options.write.write_text(with_matrix(options.write.read_text(), lines))


if __name__ == "__main__":
    main()
