"""A cracked beam on two anvils that is struck in its middle: it lifts off, and comes back (`input/one_point_bend.nml`). The reference is a beam of Timoshenko with a spring
for its crack, a rod that falls on it and anvils that only push (`tools/references/one_point_bend.py`)."""

import re
import sys

import numpy as np
import pytest

import harness
from paths import INPUT, ROOT

sys.path.insert(0, str(ROOT / "tools/references"))
from one_point_bend import struck_beam  # noqa: E402

COARSE = ("grid.cell=2e-3", "grid.cells=62,55", "energy_release.radii=4e-3", "output.snapshot_interval=0")


def test_a_struck_beam_lifts_off_from_its_anvils(hampm):
    text = (INPUT / "one_point_bend.nml").read_text()
    free = re.sub(r"&body\n   material = 'steel'\n   lower = -?5\d.*?\n/\n|&constraint.*?\n/\n", "", text, flags=re.DOTALL)
    assert free.count("&body") == 2
    run, alone = harness.run(hampm, text, *COARSE), harness.run(hampm, free, *COARSE, name="free")
    time, lift, force = run["time"], run["displacement_anvil_y"], run["reaction_left_y"]
    beam = struck_beam(100e-6)
    largest = force.max()
    back, back_of_beam = time[np.argmax(force > largest / 4)], beam[0][np.argmax(beam[5] > beam[5].max() / 4)]
    print(f"lift {1e6 * lift[time < 50e-6].max():.1f} um (beam {1e6 * beam[3].max():.1f}), back at {1e6 * back:.1f} us ({1e6 * back_of_beam:.1f}), force {largest:.0f} N ({beam[5].max():.0f})")
    assert lift[time < 50e-6].max() == pytest.approx(beam[3].max(), rel=0.25)       # it is 0.2 of what the middle has moved by
    assert back == pytest.approx(back_of_beam, abs=6e-6)
    assert largest == pytest.approx(beam[5].max(), rel=0.25)
    assert np.abs(force[(time > 12e-6) & (time < back - 8e-6)]).max() < 0.04 * largest
    assert run["reaction_right_y"] == pytest.approx(force, abs=1e-6 * largest)      # a mirror image, but for rounding
    before = time[:len(time)] < back - 2e-6
    k, k_alone = run["K_I"][before], alone["K_I"][:len(time)][before]
    print("K without anvils differs by", np.abs(k - k_alone).max() / np.abs(k).max())
    assert np.abs(k - k_alone).max() < 0.01 * np.abs(k).max()
    without = struck_beam(100e-6, has_anvils=False)
    for at in (30e-6, 60e-6):                                                       # in motion of the beam as at rest, and of another one
        found, asked = np.interp(at, alone["time"], alone["K_I"]), np.interp(at, without[0], without[1])
        print(f"K_I at {1e6 * at:.0f} us {found / 1e6:.1f} of {asked / 1e6:.1f} MPa m^0.5")
        assert found == pytest.approx(asked, rel=0.2)
    last = run.last()
    missing = run["kinetic_energy"][0] - sum(last[name] for name in ("kinetic_energy", "strain_energy", "numerical_loss", "contact_loss", "friction_loss"))
    assert abs(missing) < 1e-9 * run["kinetic_energy"][0]
