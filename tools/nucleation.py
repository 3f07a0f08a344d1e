"""Run and draw cracks that appear, of docs/explanation/nucleation.md: energy of the next crack of two laminates over crack density, and strength over the angle of a notch.

    python tools/nucleation.py build/release/hampm FOLDER PICTURE.png

Numbers go to docs/evidence/nucleation_laminates.csv and nucleation_notches.csv.
"""

import math
import subprocess
import sys
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/reference/nucleation"))
import notch  # noqa: E402
from laminate import CARBON, GLASS, Laminate  # noqa: E402
from appearing_scenes import K_IC, STRENGTH, T0, T90, beam, laminate  # noqa: E402

LENGTHS = (2e-3, 3e-3, 4e-3, 6e-3, 8e-3)
ANGLES = (60, 75, 90, 105, 120, 135, 150)
PLACES = np.array([5e-5, 7e-5, 1e-4, 1.4e-4, 2e-4])


def run(program, folder, name, text):
    (folder / f"{name}.nml").write_text(text)
    subprocess.run([program, f"{name}.nml", "--set", f"output.file={name}.h5", "--force", "--quiet"], cwd=folder, check=True, stderr=subprocess.DEVNULL)
    with h5py.File(folder / f"{name}.h5") as file:
        return {column: values[:] for column, values in file["history"].items()}


def laminates(program, folder):
    """Energy of the next crack under given load, for 1 MPa in the plies [J/m2]: by the program, by many layers, by one (Nairn)."""
    for name, of in (("carbon/epoxy", CARBON), ("glass/epoxy", GLASS)):
        many, one = Laminate(of, T90, T0, heat=0.0), Laminate(of, T90, T0, 1, heat=0.0)
        for length in LENGTHS:
            found = run(program, folder, "laminate", laminate(of, length, heat=0.0))
            compliance = found["load_factor"][0] * length * 5e-3 / found["reaction_grip_x"]
            energy = (compliance[1] - compliance[0]) / 2 / many.share**2 / T90
            layers = (2 * many.energy(length / 2) - many.energy(length)) / T90
            yield name, 1e-3 / length, 1e12 * energy, 1e12 * layers, 1e12 * one.nairn(1 / length)


def notches(program, folder):
    """Critical k [MPa m**(1 - lambda)] and length [um] by the program and by the asymptotic solution."""
    probes = "".join(f"&probe name = 'p{k}'  at = 0.0, {5e-3 + float(r)}  quantity = 'stress' /\n" for k, r in enumerate(PLACES))
    for angle in ANGLES:
        found = run(program, folder, "beam", beam(angle, extra=probes))
        k = notch.intensity(PLACES, [found[f"stress_p{n}_xx"][0] for n in range(len(PLACES))], math.radians(angle))
        length, asked = notch.onset(math.radians(angle), K_IC, STRENGTH)
        yield angle, notch.exponent(math.radians(angle)), 1e-6 * k, 1e-6 * asked, 1e6 * found["onset_length"][0], 1e6 * length


def write(name, head, rows):
    path = ROOT / "docs/evidence" / name
    path.write_text(head + "".join(",".join(f"{value:.5g}" if isinstance(value, float) else str(value) for value in row) + "\n" for row in rows))


def main(program, folder, picture):
    plt.rcParams["svg.hashsalt"] = "nucleation"
    program, folder = Path(program).resolve(), Path(folder)
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
    rows = list(laminates(program, folder))
    write("nucleation_laminates.csv", "# Energy of the next crack half way between two, under given load, for a stress of 1 MPa in the 90-degree plies: [0/90_2]s of 3 mm.\n"
          "# Made by tools/nucleation.py; theory: tests/reference/nucleation/laminate.py\n"
          "laminate,density [1/mm],hampm [J/m2],12 layers in each group [J/m2],one layer (Nairn 1989) [J/m2]\n", rows)
    for name, colour in (("carbon/epoxy", "C0"), ("glass/epoxy", "C1")):
        of = CARBON if name == "carbon/epoxy" else GLASS
        lengths = np.linspace(2e-3, 10e-3, 60)
        many, one = Laminate(of, T90, T0, heat=0.0), Laminate(of, T90, T0, 1, heat=0.0)
        left.plot(1e-3 / lengths, [1e12 * (2 * many.energy(x / 2) - many.energy(x)) / T90 for x in lengths], color=colour, label=f"{name}, 12 layers")
        left.plot(1e-3 / lengths, [1e12 * one.nairn(1 / x) for x in lengths], "--", color=colour, label="one layer (Nairn)")
        left.plot(*np.array([row[1:3] for row in rows if row[0] == name]).T, "o", color=colour, markersize=4, label="hampm")
    left.set(xlabel="cracks per mm", ylabel="energy for 1 MPa in the plies [J/m²]", title="The next crack of a laminate", ylim=(0, None))
    rows = list(notches(program, folder))
    write("nucleation_notches.csv", "# Generalised stress intensity at which a crack appears at a V-notch, stress k r**(lambda - 1) on the bisector, and the length of the crack:\n"
          f"# acrylic glass, K_Ic {K_IC / 1e6:g} MPa m**0.5, strength {STRENGTH / 1e6:g} MPa. Made by tools/nucleation.py; theory: tests/reference/nucleation/notch.py\n"
          "angle [deg],lambda,k hampm [MPa m**(1-lambda)],k theory,length hampm [um],length theory\n", rows)
    angles = np.linspace(1, 160, 100)
    right.semilogy(angles, [1e-6 * notch.onset(math.radians(a), K_IC, STRENGTH)[1] for a in angles], color="0.5", label="asymptotic solution")
    right.semilogy([row[0] for row in rows], [row[2] for row in rows], "o", markersize=4, label="hampm, beam of 18 mm")
    right.set(xlabel="angle of the notch [deg]", ylabel="critical k [MPa m$^{1-\\lambda}$]", title="Strength of V-notches")
    for axes in (left, right):
        axes.legend(frameon=False, fontsize=8)
    figure.savefig(picture, dpi=85)


if __name__ == "__main__":
    main(*sys.argv[1:])
