"""The sweeps of docs/how-to/batches.md, from the command line as it stands there: a study of twelve cases in two commands, and one of growth."""

import csv
import re
import shlex
import shutil
import subprocess
import sys

import pytest

pytest.importorskip("snakemake")

from paths import INPUT, ROOT

PAGE = (ROOT / "docs/how-to/batches.md").read_text()
STUDY, GROWTH = (next(text for text in re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL) if name in text) for name in ("output: edge_study", "output: growth_sweep"))
COMMANDS = re.findall(r"^    python (.*)$", PAGE, re.MULTILINE)
PRINTED = re.search(r"^```\n(zone=.*?)```", PAGE, re.MULTILINE | re.DOTALL)[1]


def run(folder, command):
    result = subprocess.run([sys.executable, *shlex.split(command.replace("batch/", f"'{ROOT}'/batch/").replace("postprocess/", f"'{ROOT}'/postprocess/"))], cwd=folder,
                            capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture
def folder(tmp_path):
    """The models and the sweeps, in a folder with a blank in its name."""
    place = tmp_path / "my sweeps"
    place.mkdir()
    for model in ("edge_crack.nml", "dcb_growth.nml"):
        shutil.copy(INPUT / model, place)
    (place / "edge_study.yaml").write_text(STUDY)
    (place / "growth_sweep.yaml").write_text(GROWTH)
    return place


def test_a_study_of_twelve_cases_in_two_commands(folder):
    """K of the crack from one edge: first order, the handbook's value to its 0.5 %, and what the page shows of it."""
    assert len(COMMANDS) == 2
    assert run(folder, COMMANDS[0]).splitlines()[-1].startswith("12 cases: 12 done; ")
    said = run(folder, COMMANDS[1])
    assert said.count("the last three tend to") == 4 and "12 cases in 4 groups" in said and (folder / "edge_study/study_Y.png").exists()
    rows = table(folder / "edge_study/study_Y.csv")
    finest = [row for row in rows if row["$h"] == "0.25e-3"]
    assert len(finest) == 4 and all(abs(float(row["error_percent"])) < 0.5 and abs(float(row["extrapolated"]) / 2.1064 - 1) < 0.005 for row in finest)

    def numbers(text):
        """All but the times."""
        return [float(word) for line in text.splitlines()[1:] if (words := line.split())[0] != "$h" for word in (words[:5] if words[0] != "the" else words)
                if re.fullmatch(r"[-+\d.]+", word) and word != "-"]
    shown = said[said.index("zone=8e-3:"):].split("\n\n")[0]
    assert numbers(shown) == pytest.approx(numbers(PRINTED), rel=2e-2)


def test_a_sweep_of_growth_with_columns_that_are_derived(folder):
    """The load at which a beam begins to split is the beam's on a foundation to 1 %, whatever the toughness; it grows by the increment each step."""
    run(folder, COMMANDS[0].replace("edge_study", "growth_sweep"))
    rows = table(folder / "growth_sweep/table.csv")
    assert len(rows) == 6 and all(float(row["ratio"]) == pytest.approx(1, abs=0.01) for row in rows)
    assert [float(row["crack_length"]) for row in rows] == pytest.approx(3 * [60e-3, 70e-3]) and [float(row["t_60"]) for row in rows] == pytest.approx(3 * [4, 2])
