"""The tables that `make verify` writes, the report of `make verification`, and that what stands in the docs is what they write."""

import csv
import re
import subprocess
import sys
from fnmatch import fnmatchcase

import pytest

from long_tests import PARTS
from paths import REGRESSION, ROOT

try:
    import tomllib
except ImportError:  # Python 3.10
    import tomli as tomllib

sys.path.insert(0, str(ROOT / "tools"))

import verification_table  # noqa: E402

TOOL = ROOT / "tools/verification_table.py"
PAGE = ROOT / "docs/evidence/verification.md"


def value(run, measured, asked=0, tolerance=0.05, failure=""):
    return f"""<testcase classname="tests.regression.test_regression" name="test_value[{run}]" time="0.1"><properties>
<property name="run" value="{run}"/><property name="what" value="|J|"/><property name="asked" value="{asked}"/><property name="tolerance" value="{tolerance}"/>
<property name="measured" value="{measured}"/><property name="source" value="a &lt;closed&gt; form"/></properties>{failure}</testcase>"""


RESULTS = f"""<testsuites><testsuite>
{value("dcb refined", 1.5, 1.287, 0.01, "<failure>off</failure>")}{value("plate 2mm", 0.04)}{value("plate 1mm", 0.01)}{value("plate 0.5mm", -0.005)}
<testcase classname="tests.program.test_run" name="test_b" time="2.4"/>
<testcase classname="tests.program.test_run" name="test_c" time="1.0"><skipped/></testcase>
</testsuite></testsuites>"""


def write(tmp_path, page, *words):
    (tmp_path / "results.xml").write_text(RESULTS)
    (tmp_path / "page.md").write_text(page)
    return subprocess.run([sys.executable, TOOL, *(words or [tmp_path / "results.xml", tmp_path / "page.md"])], capture_output=True, text=True)


def test_the_page_has_a_row_for_each_case_and_files_have_all(tmp_path):
    result = write(tmp_path, "before\n<!-- make verify: begin -->\nold\n<!-- make verify: end -->\nafter\n")
    assert result.returncode == 0, result.stderr
    page = (tmp_path / "page.md").read_text()
    assert "| `dcb` | 1 of 1 run, **1 outside** | refined: \\|J\\| | 1.287 ± 0.01 | 1.5 |\n" in page
    assert "| `plate` | 3 of 3 runs | 2mm: \\|J\\| | 0 ± 0.05 | 0.04 |\n" in page
    assert "| `tests/program` | 1 | 1 | 0 | 2 |\n" in page
    assert page.startswith("before\n") and page.endswith("after\n") and "old" not in page
    assert (tmp_path / "page_values.csv").read_text().splitlines()[:2] == [
        "run,quantity,asked,tolerance,measured,part_of_tolerance,passed", "dcb refined,|J|,1.287,0.01,1.5,21,no"]
    assert (tmp_path / "page_tests.csv").read_text() == "file,tests,failed,seconds\ntests/program/test_run.py,1,0,2\n"


def test_a_page_without_a_place_for_it_is_left_as_it_is(tmp_path):
    result = write(tmp_path, "text\n")
    assert result.returncode == 1 and "must have one place" in result.stderr
    assert (tmp_path / "page.md").read_text() == "text\n" and not list(tmp_path.glob("*.csv"))


def test_the_report_has_errors_orders_the_machine_and_what_was_not_run(tmp_path):
    result = write(tmp_path, "", "--html", tmp_path / "new/report.html", tmp_path / "results.xml")
    assert result.returncode == 0, result.stderr
    assert "4 values, 1 outside of their tolerance, " in result.stdout
    text = (tmp_path / "new/report.html").read_text()
    assert "4 values of 2 cases were measured" in text and "1 are outside of their tolerance. 1 other tests ran: 0 failed." in text
    assert "a &lt;closed&gt; form" in text and text.count("class=fails") == 2  # among the cases, and among the values
    assert "<td>2, 1, 0.5</td><td>+0.04, +0.01, -0.005</td><td>2.0, –</td>" in text  # no order where the sign changes
    assert "<td>program</td>" in text and "<td>processor</td>" in text and "results.xml, 20" in text
    not_run = text.partition("<h2>Not run</h2>")[2]
    assert "<tr><td>freund 0.1mm</td><td>error of the energy balance</td></tr>" in not_run
    assert not re.search(r"(?:src|href)=(?!'#)|url\(|@import", text)  # it needs nothing but itself


# --- what stands in the docs ------------------------------------------------------------------------------------------

def rows(name):
    with open(PAGE.with_name(f"verification_{name}.csv"), newline="") as file:
        return list(csv.DictReader(file))


def test_the_page_is_what_the_tool_makes_of_the_files_beside_it():
    others = {row["file"]: [(float(row["seconds"]) / int(row["tests"]), k < int(row["failed"])) for k in range(int(row["tests"]))] for row in rows("tests")}
    assert verification_table.with_tables(PAGE.read_text(), verification_table.summary(rows("values"), others)) == PAGE.read_text()


@pytest.mark.parametrize("case", sorted(path.parent.name for path in REGRESSION.glob("*/expected.toml")))
def test_measured_values_are_those_that_the_tests_ask_now(case):
    """Each row of the table has its test, with the asked value and tolerance of the row where these are numbers; and none of a run is missing."""
    expected = tomllib.loads((REGRESSION / case / "expected.toml").read_text())
    table = {}
    for row in rows("values"):
        if row["run"].split()[0] == case:
            table.setdefault(row["run"].partition(" ")[2], {})[row["quantity"]] = row
    assert set(table) <= set(expected.get("runs", {"": []}))
    assert set(table) == {name for name in expected.get("runs", {"": []}) if f"{case}-{name}".startswith(PARTS["test_regression"])
                          or any(fnmatchcase(name, pattern) for pattern in expected.get("verify", []))}
    for name, measured in table.items():
        asked = {item["what"]: item for item in expected["expect"] if fnmatchcase(name, item.get("runs", "*"))}
        assert set(measured) == set(asked)
        for what, row in measured.items():
            if not isinstance(asked[what]["asked"], str):
                assert float(row["asked"]) == pytest.approx(asked[what]["asked"], rel=1e-5)
                if not any(isinstance(asked[what].get(key, 0), str) for key in ("rtol", "atol")):
                    tolerance = asked[what].get("atol", 0) + asked[what].get("rtol", 0) * abs(asked[what]["asked"])
                    assert float(row["tolerance"]) == pytest.approx(tolerance, rel=0.05)
            assert row["passed"] == ("yes" if abs(float(row["measured"]) - float(row["asked"])) <= 1.05 * float(row["tolerance"]) else "no")
            assert row["part_of_tolerance"] == verification_table.part(row)
