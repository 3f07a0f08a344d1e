"""Every scene of this folder has a test, but those whose fault is still open: name and fault."""

from pathlib import Path

CASES = Path(__file__).parent
OPEN: dict[str, str] = {}


def test_every_scene_is_named_in_a_test():
    tests = "".join(path.read_text() for path in CASES.glob("test_*.py") if path.name != "test_all.py")
    assert {path.stem for path in CASES.glob("*.nml") if f'"{path.stem}"' not in tests} == set(OPEN)
