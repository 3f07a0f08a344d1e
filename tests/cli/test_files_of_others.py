"""A run replaces what runs have left, and nothing else: above all not the namelist that it is made from."""

import os
import shutil
import subprocess

import pytest

from paths import PROGRAM

SCENE = """\
&run end_time = 1e-6 /
&grid cell = 1.0 cells = 4, 4 /
&material name = 'a' young = 1e9 density = 1000 /
&body material = 'a' lower = 1.0, 1.0 upper = 3.0, 3.0 /
&output file = '{}' /
"""


def refused(run, path, text):
    """Whether a run ended with 4, named the file, and left it as it was."""
    return run.returncode == 4 and f"{path.name}: there is another file than hampm writes" in run.stderr and path.read_text() == text


@pytest.mark.parametrize("result", ["case.nml", "x"])
@pytest.mark.parametrize("ending", ["", ".part", ".last", ".lock", ".checkpoint", ".checkpoint.part"])
def test_no_file_of_a_result_is_the_namelist(hampm, tmp_path, result, ending):
    """Neither the result nor what is written beside it."""
    path = tmp_path / f"{result}{ending}"
    path.write_text(SCENE.format(result))
    assert refused(hampm(path.name, "--force"), path, SCENE.format(result))


@pytest.mark.parametrize("kind", ["symlink", "link"])
def test_no_result_goes_where_a_link_leads_to_the_namelist(hampm, tmp_path, kind):
    path, text = tmp_path / "case.nml", SCENE.format("x.h5")
    path.write_text(text)
    (tmp_path / "x.h5").symlink_to(path) if kind == "symlink" else os.link(path, tmp_path / "x.h5")
    run = hampm("case.nml", "--force")
    assert run.returncode == 4 and "x.h5: there is another file than hampm writes" in run.stderr
    assert path.read_text() == text


@pytest.mark.parametrize("output", ["sub/..", "linked", "absolute"])
def test_no_result_reaches_the_namelist_by_a_folder(hampm, tmp_path, output):
    path, text = tmp_path / "case.nml", SCENE.format("case.nml")
    path.write_text(text)
    (tmp_path / "sub").mkdir()
    (tmp_path / "linked").symlink_to(tmp_path)
    run = hampm("case.nml", "--force", "--output", tmp_path if output == "absolute" else output)
    assert refused(run, path, text)


def test_a_resumed_run_leaves_the_namelist(hampm, tmp_path):
    """The result is put beside a namelist of the same name."""
    path, text = tmp_path / "case.nml", SCENE.format("case.nml")
    path.write_text(text)
    assert hampm("case.nml", "--output", "out", "--steps", "1", "--set", "run.end_time=1e-3").returncode == 5
    run = hampm("--resume", "out/case.nml.checkpoint", "--output", ".")
    assert refused(run, path, text)
    assert hampm("--resume", "out/case.nml.checkpoint", "--steps", "1").returncode == 5


def test_what_a_run_has_left_is_replaced(hampm, tmp_path):
    """Results, what was begun of one, empty files and locks."""
    path = tmp_path / "case.nml"
    path.write_text(SCENE.format("x.h5"))
    assert hampm("case.nml").returncode == 0
    whole = (tmp_path / "x.h5").read_bytes()
    for left in (whole, whole[:1000], bytes(4096), b""):
        (tmp_path / "x.h5").write_bytes(left)
        (tmp_path / "x.h5.part").write_bytes(left)
        (tmp_path / "x.h5.lock").touch()
        assert hampm("case.nml", "--force").returncode == 0
    assert (tmp_path / "x.h5").stat().st_size > 0 and not (tmp_path / "x.h5.part").exists()


@pytest.mark.skipif(not shutil.which("bash"), reason="the shell that knows these limits")
@pytest.mark.parametrize(("limit", "words"), [("-s 100", "the stack (ulimit -s)"), ("-s 512", "the stack (ulimit -s)"),
                                              ("-v 200000", "the address space (ulimit -v)")])
@pytest.mark.parametrize("options", ["--check", "--threads 2", "--threads 1"])
def test_small_limits_end_with_a_message(tmp_path, limit, words, options):
    (tmp_path / "case.nml").write_text(SCENE.format("x.h5"))
    run = subprocess.run(["bash", "-c", f"ulimit {limit}; exec {PROGRAM} case.nml {options}"], cwd=tmp_path, capture_output=True, text=True,
                         env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}, timeout=60)
    assert run.returncode == 2 and words in run.stderr and run.stderr.startswith("hampm: "), run
