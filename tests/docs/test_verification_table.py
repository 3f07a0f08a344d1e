"""The table that `make verify` writes."""

import subprocess
import sys

from paths import ROOT

TOOL = ROOT / "tools/verification_table.py"
RESULTS = """<testsuites><testsuite>
<testcase classname="tests.regression.test_regression" name="test_value[a]" time="0.1"><properties>
<property name="run" value="dcb refined"/><property name="what" value="|J|"/><property name="asked" value="1.287"/>
<property name="tolerance" value="0.01"/><property name="measured" value="1.5"/></properties><failure>off</failure></testcase>
<testcase classname="tests.program.test_run" name="test_b" time="2.4"/>
<testcase classname="tests.program.test_run" name="test_c" time="1.0"><skipped/></testcase>
</testsuite></testsuites>"""


def write(tmp_path, page):
    (tmp_path / "results.xml").write_text(RESULTS)
    (tmp_path / "page.md").write_text(page)
    return subprocess.run([sys.executable, TOOL, tmp_path / "results.xml", tmp_path / "page.md"], capture_output=True, text=True)


def test_values_and_other_tests_have_a_table_each(tmp_path):
    result = write(tmp_path, "before\n<!-- make verify: begin -->\nold\n<!-- make verify: end -->\nafter\n")
    assert result.returncode == 0, result.stderr
    page = (tmp_path / "page.md").read_text()
    assert "| dcb refined | \\|J\\| | 1.287 ± 0.01 | 1.5 **fails** |\n" in page
    assert "| `tests/program/test_run.py` | 1 | 0 | 2 |\n" in page
    assert page.startswith("before\n") and page.endswith("after\n") and "old" not in page


def test_a_page_without_a_place_for_it_is_left_as_it_is(tmp_path):
    result = write(tmp_path, "text\n")
    assert result.returncode == 1 and "must have one place" in result.stderr
    assert (tmp_path / "page.md").read_text() == "text\n"
