"""Whether the advice of each row of docs/reference/key_rules.md can be taken: models of input/, changed until the row refuses them or warns of them, then changed as it advises.

    .venv/bin/python tests/fuzz/advice_rows.py
    .venv/bin/python tests/fuzz/advice_rows.py --row "material_force" --models 9

A row is met by giving keys the values that it names, in each model until `--models` of them have met it. Advice is taken where its row refuses no longer and no message
begins with what was advised, at once or, where another advice is refused in turn, by taking that too (`advice.py`). Rows whose advice is in words are listed, not tried. Exit
code 1 where an advice is still refused.
"""

import argparse
import itertools
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from accepted import shortened
from advice import ADVICE, follow, taken
from combinations import ROOT

PROGRAM, SOLID_PROGRAM = Path(os.environ.get("HAMPM", ROOT / "build/release/hampm")), Path(os.environ.get("HAMPM3D", ROOT / "build/release3d/hampm3d"))
GROUPS = {"growth": "law = 'quasi_static'  direction = 'straight'  toughness = 100.0  increment = 1e-3", "cohesive": "strength = 1e6  toughness = 100.0",
          "nucleation": "law = 'coupled'  strength = 1e6  toughness = 100.0", "contact": "bodies = 'frictionless'", "control": "quantity = 'load'", "cycles": "ratio = 0.1",
          "refine": "indicator = 'tip'", "probe": "quantity = 'displacement'  at = 0.0, 0.0"}
LAWS = {"j2_plastic": "yield_stress = 1e8", "viscoelastic": "moduli = 1e9  relaxation_times = 1.0", "mooney_rivlin": "c01 = 1e5",
        "orthotropic": "young_1 = 1e11  young_2 = 1e10  shear_12 = 5e9  poisson_12 = 0.3"}
GROWTHS = {"prescribed": "speed = 100.0", "fatigue": "increment = 1e-3  rate_constant = 1e-29  rate_exponent = 3.0",
           "subcritical": "increment = 1e-3  rate = 'charles'  speed = 1e-3  rate_exponent = 5.0"}
CONDITION = re.compile(r"&(\w+)(?: (\w+)(?: (=|/=|<|>) ([^&]*?))?)?(?= and | or |$)")
SIZES = ("0.01", "1.0", "0.0, 1.0", ".true.")      # of keys that only have to be given
WORDS = {"a mass matrix that acts": ("method", "time", "'explicit'"), "quadratic cells": ("grid", "order", "2"), "several cracks": ("crack", "", "")}
ALL_MODELS = [*sorted((ROOT / "input").glob("*.nml")), *sorted((ROOT / "input/solid").glob("*.nml"))]


def flat(text):
    """A model with each group on a line, without comments."""
    lines = [re.sub(r"^((?:[^'!]|'[^']*')*)!.*", r"\1", line).strip() for line in text.splitlines()]
    return re.sub(r"\s*\n\s*(?!&)", " ", "\n".join(line for line in lines if line)) + "\n"


def choices(condition):
    """Values of a key that meet a condition of a row; none of one in words."""
    group, key, sign, value = condition
    if not key:
        return [(group, "", "")]
    if not sign:
        return [(group, key, size) for size in SIZES]
    if sign == "=":
        return [(group, key, one.strip()) for one in value.split("|")]
    if sign == "/=":
        return []
    number = float(value)
    return [(group, key, str(number + 0.01 if sign == ">" else int(number) - 1))]


def meets(text, changes):
    """A model with the values of a row, and what these need to be a model."""
    for group, key, value in changes:
        if not key:
            if not re.search(rf"^\s*&{group}\b", text, re.M) and group in GROUPS:
                text += f"&{group} {GROUPS[group]} /\n"
            continue
        needs = (LAWS if group == "material" else GROWTHS if group == "growth" else {}).get(value.strip("'"), "") if key == "law" else ""
        if group in GROUPS and not re.search(rf"^\s*&{group}\b", text, re.M):
            text += f"&{group} {GROUPS[group]} /\n"
        if group == "growth" and value in ("'prescribed'", "'toughness'") and "law" == key:
            text = re.sub(r"(?s)&cycles.*?^/|&cycles[^\n]*/|increment *= *\S+", "", text)
        for name, given in re.findall(r"(\w+) = ([^=]+?)(?=\s+\w+ =|$)", needs):
            text = taken(text, group, name, given)
        text = taken(text, group, key, value)
    return text


def messages(program, text, folder):
    """What refuses a model or warns of it."""
    (folder / "case.nml").write_text(text)
    run = subprocess.run([program, "--check", "--quiet", "case.nml"], cwd=folder, capture_output=True, text=True)
    said = run.stderr + run.stdout
    return tuple(re.sub(r"^(hampm|!|! note|! warning|hampm: warning): *(note: |warning: )?(case\.nml:\d+: )?(warning: )?", "", line) for line in said.splitlines() if "; use " in line)


def is_of(message, row):
    """Whether a message is that of a row."""
    group, key = re.match(r"&(\w+)(?: (?!and )(\w+))?", row["subject"]).groups(default="")
    return row["use"] in message and row["reason"] in message and f"&{group}" in message and key in message


def models_of(row, all_models):
    """Models on which a row may be met, with their programs."""
    solid = "a solid" in f"{row['subject']} {row['other']}" and row["verdict"] != "requires"
    return [(SOLID_PROGRAM if path.parent.name == "solid" else PROGRAM, path) for path in all_models if not solid or path.parent.name == "solid"]


def try_row(row, most, folder):
    """What refuses the advice of a row in the end, in each model that has met it: '' where it is taken."""
    sides = [row["subject"]] + ([row["other"]] if row["verdict"] != "requires" else [])
    options = [[change] for words, change in WORDS.items() if words in row["other"]]
    options += [found for side in sides for condition in CONDITION.findall(side) if (found := choices(condition))]
    ends = []
    for program, path in models_of(row, ALL_MODELS):
        for changes in itertools.islice(itertools.product(*options), 12):
            text = meets(flat(path.read_text()), changes)
            met = [message for message in messages(program, text, folder) if is_of(message, row)]
            if not met:
                continue
            found = ["" if taken_warning(program, text, message, folder) else follow(program, text, message, folder) for message in each_choice(met[0])]
            ends.append((path.stem, changes, "" if "" in found else found[0]))
            break
        if len(ends) == most:
            break
    return ends


def each_choice(message):
    """A message for each value that it leaves to choose from: 'plane' | 'symmetry'."""
    before, use, advice = message.partition("; use ")
    values = re.findall(r"'[^']*'", advice)
    return [before + use + advice.replace(values[0], value, 1) for value in values] if "|" in advice or " or " in advice else [message]


def taken_warning(program, text, message, folder):
    """Whether a model that is only warned of is accepted without that warning as it advises."""
    if subprocess.run([program, "--check", "--quiet", "case.nml"], cwd=folder, capture_output=True).returncode != 0:
        return False
    group, key, value = ADVICE.search(message).groups()
    after = messages(program, taken(text, group, key, value), folder)
    code = subprocess.run([program, "--check", "--quiet", "case.nml"], cwd=folder, capture_output=True).returncode
    return code == 0 and not any(shortened(other) == shortened(message) for other in after)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", type=int, default=3, metavar="N", help="that meet each row")
    parser.add_argument("--row", default="", help="only rows with this text")
    options = parser.parse_args()
    rows = [row for row in json.loads(subprocess.run([PROGRAM, "--rules", "--json"], capture_output=True, text=True, check=True).stdout) if row["use"]]
    rows = [row for row in rows if options.row in " ".join(row.values())]
    words = [row for row in rows if not ADVICE.search("; use " + row["use"])]
    tried, refused, never, n = 0, {}, [], 0
    with tempfile.TemporaryDirectory() as folder:
        for row in rows:
            if row in words:
                continue
            ends = try_row(row, options.models, Path(folder))
            n += len(ends)
            tried += bool(ends)
            name = f"{row['subject']} {row['verdict']} {row['other']}; use {row['use']}"
            if not ends:
                never.append(name)
            if any(end for _, _, end in ends):
                refused[name] = ends
    print(f"rows with advice {len(rows)}, in words {len(words)}, tried {tried} in {n} models, taken {tried - len(refused)}, still refused {len(refused)}, never met {len(never)}")
    for name, ends in refused.items():
        print("\nstill refused: " + name)
        for stem, changes, end in ends:
            print(f"    {stem} with {changes}: {end or 'taken'}")
    for name in never:
        print("\nnever met: " + name)
    for row in words:
        print(f"\nin words: {row['subject']} {row['verdict']} {row['other']}; use {row['use']}")
    sys.exit(bool(refused))


if __name__ == "__main__":
    main()
