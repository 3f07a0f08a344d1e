"""Whether what a refusal advises can be taken: scenes at random that are refused, each changed as the message says after "use", once and, where that is refused in turn, once more.

    .venv/bin/python tests/fuzz/advice.py --cases 900 --seed 900

Scenes are those of `accepted.py`. Advice is taken where its row refuses no longer and no message begins with what was advised. A row of docs/reference/key_rules.md that is met counts
as tried, taken where that holds in each scene, else still refused: these are listed, each with the message that refuses its advice. Exit code 1 where there is one.
"""

import argparse
import random
import re
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

from accepted import keys_in, refusals, shortened
from combinations import PROGRAM
from drawn_scenes import draw, text_of

ADVICE = re.compile(r"; use (?:&(\w+) (\w+) = )?('[^']*'|(?<== )[^\s,;|]+)")  # without a key it is of that of the message
STEPS = 2


def taken(text, group, key, value):
    """A namelist with an advice taken in all groups of a name, or in a new one."""
    lines, found = [], False
    for line in text.splitlines():
        if re.match(rf"\s*&{group}\b", line):
            found = True
            line = re.sub(rf"(?<=[\s,]){key}\s*=\s*.*?(?=\s\w+\s*=|\s*/\s*$|$)", "", line)
            line = re.sub(rf"&{group}\b", f"&{group}  {key} = {value} ", line, count=1)
        lines.append(line)
    if not found:
        lines.append(f"&{group}  {key} = {value} /")
    return "\n".join(lines) + "\n"


def follow(program, text, message, folder):
    """What refuses the advice of a message in the end; '' where it is taken."""
    first, advised = keys_in(message)[:1], []
    for _ in range(STEPS):
        group, key, value = ADVICE.search(message).groups()
        if key is None:
            group, key = keys_in(message)[0]
        advised.append((group, key))
        text = taken(text, group, key, value)
        left = [other for other in refusals(program, text, folder) if other == message or keys_in(other)[:1] in ([advised[-1]], first)]
        left = [other for other in left if shortened(other) == shortened(message) or keys_in(other)[:1] == [advised[-1]]]
        if not left:
            return ""
        message = next((other for other in left if ADVICE.search(other)), None)
        if message is None:
            return left[0]
    return message


def try_advice(program, cases, seed):
    """Of each row that is met: what refuses its advice in the end in each scene, '' where it is taken."""
    ends = defaultdict(list)
    with tempfile.TemporaryDirectory() as folder:
        for number in range(cases):
            scene = draw(random.Random(f"{seed} {number}"))
            for message in refusals(program, scene, Path(folder)):
                if ADVICE.search(message):
                    ends[shortened(message)].append(follow(program, text_of(scene), message, Path(folder)))
    return ends


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=900, metavar="N")
    parser.add_argument("--seed", type=int, default=900, metavar="N")
    parser.add_argument("--program", type=Path, default=PROGRAM, metavar="FILE")
    options = parser.parse_args()
    ends = try_advice(options.program.resolve(), options.cases, options.seed)
    still = {row: [end for end in found if end] for row, found in ends.items() if any(found)}
    print(f"rows tried {len(ends)} in {sum(map(len, ends.values()))} scenes, taken {len(ends) - len(still)}, still refused {len(still)}")
    for row, found in still.items():
        print(f"\n{row}\n    {len(found)} of {len(ends[row])}, as {found[0]}")
    sys.exit(bool(still))


if __name__ == "__main__":
    main()
