"""Read namelists and command lines that are changed at random, and compare what is understood with a second reader:

    python tests/fuzz/fuzz.py [--cases 10000] [--seed 1] [--build checked]

All that `--check` does is done with each. Exit code 1 and the case where the program crashes, hangs, takes more than 2 s of processor time,
reports in other ways than by a message, or accepts what means something else than it says. Else a table of the counts.
"""

import argparse
import os
import random
import re
import struct
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import every_key
import mutations
import oracle

ROOT = Path(__file__).resolve().parents[2]
BATCH = 5000  # cases that one process reads
PART = 50000  # cases of one seed
LONGEST = 2.0  # processor time of a case [s]
SMALL = """\
&run thickness = 0.01 end_time = 1e-5 /
&grid cell = 5e-3 cells = 20, 5 /
&material name = 'aluminium' young = 70e9 poisson = 0.3 density = 2700 /
&body material = 'aluminium' lower = 0.0, 0.0 upper = 0.1, 0.02 points_per_cell = 2 /
"""
HALF = SMALL + """\
&constraint lower = 0.05, 0.0 upper = 0.1, 0.0 fix = 'y' /
&load kind = 'traction' lower = 0.0, 0.0 upper = 0.0, 0.02 force = 0.0, 1.0 /
&crack tip = 0.05, 0.0 /
"""
LINE = SMALL + """\
&load kind = 'point' lower = 0.0, 0.02 upper = 0.0, 0.02 force = 0.0, 1.0 history = 'table' times = 0.0, 1e-6 factors = 0.0, 1.0 /
&load kind = 'body' lower = 0.0, 0.0 upper = 0.01, 0.01 force = 0.0, -1.0 history = 'ramp' rise_time = 1e-6 /
&crack kind = 'line' tip = 0.05, 0.01 contact = 'frictionless' /
"""
SMALL_SCENES = [
    SMALL, HALF, LINE,
    HALF + "&refine indicator = 'tip' rings = 2 max_level = 3 /\n&energy_release estimators = 'vcct', 'stress_closure' /\n",
    HALF + "&method mass = 'consistent' solver = 'direct' frame = 'total' /\n&output snapshot_interval = 1e-6 /\n",
    HALF + "&method mass = 'partial' consistent_lower = 0.04, 0.0 consistent_upper = 0.06, 0.02 solver = 'direct' /\n",
    LINE + "&refine indicator = 'gradient' max_level = 2 region_lower = 0.0, 0.0 region_upper = 0.1, 0.02 /\n",
    LINE + "&method mass = 'fmpm' order = 3 /\n&energy_release estimators = 'domain_integral' radii = 0.01 /\n",
]
FEATURES = list(every_key.SCENES.values())
SCENES = SMALL_SCENES + FEATURES + [path.read_text() for path in sorted([*ROOT.glob("input/*.nml"), *ROOT.glob("tests/regression/*/case.nml")])]


class Finding(Exception):
    """Something that must not be."""


def make_case(random):
    """A kind of change and the texts of the case: those of a namelist and its overrides, or arguments."""
    kind = random.choices(list(mutations.WEIGHTS), list(mutations.WEIGHTS.values()))[0]
    if kind == "arguments":
        return kind, 0, mutations.arguments(random)
    base = random.randrange(len(SMALL_SCENES) + len(FEATURES)) if random.random() < 0.8 else random.randrange(len(SCENES))
    text, overrides = SCENES[base], []
    if kind == "override":
        overrides = [mutations.override(random) for _ in range(random.choice([1, 1, 2]))]
    else:
        text = mutations.KINDS[kind](text, random)
        if kind != "style" and isinstance(text, str) and random.random() < 0.2:
            text = mutations.KINDS[random.choice(["value", "byte", "line"])](text or "\n", random)
    return kind, base, [text if isinstance(text, bytes) else text.encode(), *overrides]


def answers(driver, cases, folder):
    """The driver's answers (code, processor time, text) to cases (kind, base, texts)."""
    asked, answered = folder / "cases", folder / "answers"
    answered.write_bytes(b"")
    with asked.open("wb") as file:
        for kind, _, texts in cases:
            file.write(struct.pack("ii", 2 if kind == "arguments" else 1, len(texts)))
            for text in texts:
                file.write(struct.pack("i", len(text)) + text)
    try:
        run = subprocess.run([driver, asked, answered], capture_output=True, text=True, errors="replace", timeout=3600,
                             env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"})
        end = f"exit code {run.returncode}\n{run.stdout}{run.stderr}"
    except subprocess.TimeoutExpired:
        end = "it did not end"
    data, at, found = answered.read_bytes(), 0, []
    while at < len(data):
        code, milliseconds, length = struct.unpack_from("iii", data, at)
        found.append((code, milliseconds / 1000, data[at + 12:at + 12 + length]))
        at += 12 + length
    if len(found) < len(cases) or not end.startswith("exit code 0\n"):
        raise Finding(f"the driver stopped at case {len(found)}: {end[:3000]}\n{cases[min(len(found), len(cases) - 1)]}")
    return found


MESSAGE = re.compile(rb"[\x20-\x7e\n]+")


def as_used(text):
    """The model as used, of an answer: nothing of one whose lattice is yet to be chosen."""
    return text[:text.rfind(b"\n/\n") + 3] if b"\n/\n" in text else b""


def check_answer(case, answer, plain, keys):
    """Whether a case was accepted; a `Finding` where the answer is wrong. `plain` are the scenes without any change, as used."""
    kind, base, texts = case
    code, seconds, text = answer
    if code not in (0, 2):
        raise Finding(f"exit code {code}: {text}")
    if seconds > LONGEST:
        raise Finding(f"{seconds:.1f} s of processor time")
    if code == 2 and not MESSAGE.fullmatch(text):
        raise Finding(f"message {text}")
    try:
        if kind == "arguments":
            wanted = oracle.command_line(texts)
            wrong = [] if code or text == wanted else [f"{text} in place of {wanted}"]
            if code:
                wrong = [f"refused: {text}"]
        elif code:
            wrong = []
        else:
            wrong = oracle.differences(texts[0], texts[1:], as_used(text), keys) if as_used(text) else []
            if kind == "style" and as_used(text) != plain[base]:
                wrong.append("another style is another scene")
    except oracle.Refused as reason:
        wrong = [] if code else [f"accepted, but: {reason}"]
    if kind == "style" and code:
        wrong.append(f"another style is refused: {text}")
    if wrong:
        raise Finding("\n".join(wrong))
    return code == 0


def fuzz(cases, seed, driver, program):
    """Counts by kind of change, `counts[kind, accepted]`, and the longest time of a case; raises `Finding`."""
    keys = oracle.Keys(subprocess.run([program, "--template"], capture_output=True, text=True, check=True).stdout)
    counts, source, longest = Counter(), random.Random(seed), 0.0
    with tempfile.TemporaryDirectory() as folder:
        given = answers(driver, [("none", base, [text.encode()]) for base, text in enumerate(SCENES)], Path(folder))
        plain = [as_used(text) for _, _, text in given]
        for first in range(0, cases, BATCH):
            batch = [make_case(source) for _ in range(min(BATCH, cases - first))]
            for number, (case, answer) in enumerate(zip(batch, answers(driver, batch, Path(folder)))):
                longest = max(longest, answer[1])
                try:
                    counts[case[0], check_answer(case, answer, plain, keys)] += 1
                except Finding as finding:
                    raise Finding(f"seed {seed}, case {first + number}, {case[0]}: {finding}\n{case[2]}") from finding
    return counts, longest


def table(counts):
    """The counts as text."""
    lines = ["| change | cases | accepted | refused |", "|---|---|---|---|"]
    for kind in [*mutations.WEIGHTS, "all"]:
        accepted, refused = (sum(n for (of, is_so), n in counts.items() if is_so == which and kind in (of, "all"))
                             for which in (True, False))
        lines.append(f"| {kind} | {accepted + refused} | {accepted} | {refused} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=10000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--build", default="checked", help="which build reads them")
    options = parser.parse_args()
    folder = ROOT / "build" / options.build
    counts, longest = Counter(), 0.0
    try:
        for first in range(0, options.cases, PART):
            cases, seed = min(PART, options.cases - first), options.seed + first // PART
            found, time = fuzz(cases, seed, folder / "fuzz_driver", folder / "hampm")
            counts, longest = counts + found, max(longest, time)
            print(f"{first + cases} cases", file=sys.stderr)
        print(table(counts), f"\nlongest: {longest:.3f} s of processor time")
    except Finding as finding:
        sys.exit(f"finding: {finding}")


if __name__ == "__main__":
    main()
