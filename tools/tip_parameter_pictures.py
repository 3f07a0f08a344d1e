"""Pictures of tip parameters: K of input/interface_crack.nml over the ratio of the moduli, and of input/graded_plate.nml over the gradient.

    .venv/bin/python tools/tip_parameter_pictures.py interface|graded PROGRAM FOLDER
"""

import cmath
import math
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "postprocess"), str(ROOT / "tools/references")]

from graded_references import intensities  # noqa: E402
from pictures import plt  # noqa: E402

TENSION = 1e6


def run(program, folder, scene, name, *settings):
    """The last row of a run, and its file."""
    words = [word for setting in settings for word in ("--set", setting)]
    subprocess.run([program, ROOT / "input" / f"{scene}.nml", "--output", folder, "--force", "--quiet", "--set", f"output.file={name}.h5", *words], check=True)
    with h5py.File(folder / f"{name}.h5") as file:
        return {column: values[-1] for column, values in file["history"].items()}


def draw_stress(axes, path, half, unit, label):
    """Stress across the crack at the particles in a window, over a unit."""
    with h5py.File(path) as file:
        data = file["VTKHDF/particles"]
        n = data["NumberOfPoints"][-1]
        x = data["Points"][-n:, :2]
        stress = data["PointData"]["stress_yy"][-n:].ravel() / unit
    near = np.all(np.abs(x) < half, axis=1)
    top = np.quantile(np.abs(stress[near]), 0.997)
    shown = axes.tripcolor(x[near, 0], x[near, 1], stress[near], shading="gouraud", cmap="RdYlBu_r", vmin=-top, vmax=top)
    axes.plot([-1, 1], [0, 0], "k-", lw=1)
    axes.set(aspect="equal", xlabel="$x$ [m]", ylabel="$y$ [m]", xlim=(-half, half), ylim=(-half, half))
    plt.colorbar(shown, ax=axes, label=label, shrink=0.8, extend="both")


def interface(program, folder):
    ratios, size, phase = [1.5, 3, 10, 30, 100], [], []
    for ratio in ratios:
        along = 0.3 / 0.7 * (1 - 1 / ratio) * TENSION * 20
        found = run(program, folder, "interface_crack", f"interface_{ratio}", f"material(2).young={70e9 * ratio}", f"load(3).force={along}, 0.0", f"load(4).force={-along}, 0.0")
        mu, kappa = [1.0, ratio], 3 - 4 * 0.3
        epsilon = math.log((kappa / mu[0] + 1 / mu[1]) / (kappa / mu[1] + 1 / mu[0])) / (2 * math.pi)
        exact = TENSION * (1 + 2j * epsilon) * cmath.exp(-1j * epsilon * math.log(2)) * math.sqrt(math.pi)
        k = complex(found["K_I"], found["K_II"])
        print(ratio, epsilon, abs(k) / abs(exact) - 1, math.degrees(cmath.phase(k / exact)))
        size.append(k.real / TENSION), phase.append(math.degrees(cmath.phase(k)))
    exact = []
    for ratio in np.geomspace(1, 150, 60):
        epsilon = math.log((kappa + 1 / ratio) / (kappa / ratio + 1)) / (2 * math.pi)
        exact.append((ratio, (1 + 2j * epsilon) * cmath.exp(-1j * epsilon * math.log(2)) * math.sqrt(math.pi)))
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(11, 3.4), layout="constrained")
    draw_stress(left, folder / "interface_10.h5", 3, TENSION, r"$\sigma_{yy}$ over the tension")
    for axes, values, of, label in ((middle, size, lambda k: k.real, r"$K_I$ at 1 m over $\sigma$ [m$^{1/2}$]"), (right, phase, lambda k: math.degrees(cmath.phase(k)), "phase at 1 m [degrees]")):
        axes.semilogx([ratio for ratio, _ in exact], [of(k) for _, k in exact], "k-", label="Rice & Sih (1965)")
        axes.semilogx(ratios, values, "o", label="hampm")
        axes.set(xlabel="ratio of Young's moduli", ylabel=label)
        axes.legend(frameon=False)
    middle.set_ylim(1.7, 1.8)
    figure.savefig(folder / "interface_crack.png", dpi=110)


def graded(program, folder):
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.4), layout="constrained")
    gradients, found = [0.05, 0.125, 0.25, 0.375, 0.5], []
    for beta in gradients:
        ends = f"{math.exp(-16 * beta)!r},{math.exp(16 * beta)!r}"
        row = run(program, folder, "graded_plate", f"graded_{beta}", f"body.profile_stiffness={ends}")
        found.append([row["K_I"], row["K_I_tip2"]])
    draw_stress(left, folder / "graded_0.5.h5", 3, 1e6, r"$\sigma_{yy}/(E_0 \epsilon)$")
    exact = np.array([intensities(beta) for beta in gradients])
    for tip, name in enumerate(("stiff", "soft")):
        right.plot(gradients, exact[:, tip], "k-", label="integral equation" if tip == 0 else None)
        right.plot(gradients, np.array(found)[:, tip] / (1e6 * math.sqrt(math.pi)), "os"[tip], label=f"hampm, {name} tip")
    right.set(xlabel=r"gradient $\beta a$", ylabel=r"$K_I/(E_0 \epsilon \sqrt{\pi a})$")
    right.legend(frameon=False)
    figure.savefig(folder / "graded_plate.png", dpi=110)


if __name__ == "__main__":
    globals()[sys.argv[1]](sys.argv[2], Path(sys.argv[3]))
