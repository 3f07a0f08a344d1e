"""Every scene of this folder has a test, but those whose fault is still open."""

from pathlib import Path

CASES = Path(__file__).parent
OPEN = {
    "K_jump_updated_frame": "bonds ahead of a tip that moves to another cell begin without the traction that the material had there",
}


def test_every_scene_is_named_in_a_test():
    tests = "".join(path.read_text() for path in CASES.glob("test_*.py") if path.name != "test_all.py")
    assert {path.stem for path in CASES.glob("*.nml") if f'"{path.stem}"' not in tests} == set(OPEN)
