"""Make a Jupyter notebook of each lesson, beside its page: docs/lessons/<lesson>.ipynb.

    .venv/bin/python tools/notebooks.py [PAGE.md ...]

A command of the page becomes a cell of its own, and the picture that the commands draw one that shows it; the rest is text. Cells run in the folder of this repository,
by any Python that has IPython; an answer is folded up, between its cells.
"""

import re
import sys
from pathlib import Path

import jupytext

ROOT = Path(__file__).resolve().parents[1]
LESSONS = ROOT / "docs/lessons"
SHELL = re.compile(r"^```sh\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def commands_of(block):
    """The commands of a block, which may go on behind a backslash or within quotes."""
    command = ""
    for line in block.splitlines():
        command += line
        if not command.endswith("\\") and command.count("'") % 2 == 0:
            yield command
            command = ""
        else:
            command += "\n"


def cell(code):
    return f"```python\n{code}\n```"


def cell_of(command):
    """A cell that fails where the command does; of one that is meant to, where it does not."""
    wanted = re.search(r" +# exit code (\d+)$", command)
    return cell("%%bash\n" + (f"{command[:wanted.start()]} || test $? -eq {wanted[1]}{wanted[0]}" if wanted else command))


def folded(answer):
    """An answer of which each piece of text between two cells is folded up."""
    pieces = re.split(r"(^```python\n.*?^```$)", answer[1], flags=re.DOTALL | re.MULTILINE)
    return "\n\n".join(piece if k % 2 else f"<details>\n<summary>Answer</summary>\n\n{piece.strip()}\n\n</details>"
                       for k, piece in enumerate(pieces) if piece.strip())


def notebook_of(page, root=ROOT):
    """The notebook of a page, whose cells run in the folder `root`."""
    text = SHELL.sub(lambda block: "\n\n".join(map(cell_of, commands_of(block[1]))), page)
    text = re.sub(r"^!\[.*?\]\((\w+\.png)\)$", lambda picture: cell(f'from IPython.display import Image\nImage("results/lessons/{picture[1]}")')
                  if f"results/lessons/{picture[1]}" in page else picture[0], text, flags=re.MULTILINE)
    text = re.sub(r"^<details>\n<summary>Answer</summary>\n(.*?)^</details>$", folded, text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^```math\n(.*?)\n```$", r"$$\n\1\n$$", text, flags=re.DOTALL | re.MULTILINE)  # as pages of GitHub have formulas
    text = re.sub(r"\$`(.*?)`\$", r"$\1$", text)
    title, _, rest = text.partition("\n")
    notebook = jupytext.reads(f"{title}\n\n{cell(f'%cd -q {root}')}\n{rest}", fmt="md")
    notebook.metadata["kernelspec"] = {"display_name": "Python 3", "language": "python", "name": "python3"}
    return notebook


if __name__ == "__main__":
    for path in [Path(name) for name in sys.argv[1:]] or sorted(LESSONS.glob("[0-9]*_*.md")):
        jupytext.write(notebook_of(path.read_text()), path.with_suffix(".ipynb"))
        print(path.with_suffix(".ipynb"))
