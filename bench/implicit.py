"""What implicit steps reach and cost (docs/explanation/implicit.md).

    beam    the undamped double cantilever beam under a sudden load, refined around the tip: G(t) below 50 kHz over 0.6 ms against
            explicit steps with the same mesh and mass matrix, and against converged finite elements
    chen    Chen's problem, where waves matter: K_I(t) over 0.2 us against independent finite elements

Run by `make -C bench implicit`, about ten minutes, most of it explicit steps with the consistent mass matrix; or for one part:
.venv/bin/python bench/implicit.py chen
"""

import sys

import numpy as np
from program_runs import Program
from tables import ROOT, command_line, write

sys.path.insert(0, str(ROOT / "postprocess"))

from history import lowpass, moving_mean, read_curve  # noqa: E402

BEAM = ROOT / "tests/regression/dcb_refined/case.nml"
CHEN = ROOT / "tests/regression/chen/case.nml"
CUT = 5e4        # what G(t) is compared below [Hz]
WITHIN = 0.6e-3  # and up to which time [s]
MESHES = {"5 mm, 6 levels": [], "2.5 mm, 5 levels": ["grid.cell=2.5e-3", "grid.cells=40,5", "refine.max_level=5"]}
UNDAMPED = ["damping.rate=0", "method.frame=total", "method.courant=0", "run.end_time=0.7e-3",
            "energy_release.estimators='vcct'", "energy_release.energy_balance=.false.", "output.history_interval=2e-6"]
STEPS = (0.25e-6, 0.5e-6, 1e-6, 2e-6)  # [s]
COURANT = (0.5, 1, 2, 4)
SHEAR = 3922.2   # speed of shear waves in Chen's problem, to which courant refers [m/s]: samples are a step apart at least


def rms(values):
    return np.sqrt(np.mean(values**2))


def beam(program, turns):
    def below(times, values):
        return lowpass(times, values, CUT)[times <= WITHIN]

    times, exact = read_curve(ROOT / "tests/reference/dcb_dynamic_undamped.csv", 1)
    rows = [("mesh", "mass", "steps", "dt [s]", "number", "CPU [s]", "part of explicit", "rms from explicit", "rms from reference")]
    for mesh, cells in MESHES.items():
        for mass in ("lumped", "consistent"):
            settings = [*UNDAMPED, *cells, f"method.mass={mass}", "method.solver=direct"]
            done = program(BEAM, settings, turns=1 if mass == "consistent" else turns)
            explicit, g_ref, common = done.columns, done.attributes["G_ref"], done.seconds
            peak = np.max(explicit["G_vcct_I"])
            reference = below(explicit["time"], np.interp(explicit["time"], times, exact) * g_ref)
            for dt in (None, *STEPS):
                columns, seconds = explicit, common
                if dt:
                    done = program(BEAM, [*settings, "method.time=implicit", f"method.time_step={dt}"], turns=turns)
                    columns, seconds = done.columns, done.seconds
                g = below(columns["time"], columns["G_vcct_I"])
                from_explicit = rms(g - below(explicit["time"], explicit["G_vcct_I"])) / peak
                rows.append((mesh, mass, "implicit" if dt else "explicit", f"{columns['dt'][-1]:.2g}",
                             int(columns["step"][-1]), f"{seconds:.2f}", f"{seconds / common:.3f}", f"{from_explicit:.4f}",
                             f"{rms(g - reference) / peak:.4f}"))
    return rows


def chen(program, turns):
    times, exact = read_curve(CHEN.with_name("reference.csv"), 2)
    compared = times <= 13.95e-6
    rows = [("cells", "mass", "steps", "courant", "hht_alpha", "CPU [s]", "part of explicit", "rms error of K_I", "largest")]
    for cell, cells, masses in ((0.2e-3, "51,101", ("lumped", "consistent")), (0.1e-3, "101,201", ("lumped",))):
        settings = [f"grid.cell={cell}", f"grid.cells={cells}", "method.frame=total", "energy_release.estimators='domain_integral'", "energy_release.energy_balance=.false."]
        kinds = [("explicit", 0.8, 0.0, "lumped"),
                 *(("implicit", courant, alpha, mass) for mass in masses for courant in COURANT for alpha in (0.0, -0.1))]
        for steps, courant, alpha, mass in kinds:
            done = program(CHEN, [*settings, f"method.time={steps}", f"method.courant={courant}",
                                              f"method.hht_alpha={alpha}", f"method.mass={mass}",
                                              f"output.history_interval={max(2e-8, courant * cell / SHEAR)}"], turns=turns)
            columns, seconds = done.columns, done.seconds
            common = seconds if steps == "explicit" else common
            error = (moving_mean(times, interpolated(columns, times), 0.2e-6) - exact)[compared] / exact.max()
            rows.append((f"{cell * 1e3:.1f} mm", mass, steps, courant, alpha, f"{seconds:.2f}", f"{seconds / common:.2f}",
                         f"{rms(error):.4f}", f"{abs(error).max():.4f}"))
    return rows


def interpolated(columns, times):
    """K_I at given times, linear between samples."""
    return np.interp(times, columns["time"], columns["K_I"])


def main():
    arguments = command_line(__doc__, ["beam", "chen"], "results/implicit",
                             repeats=(3, "measurements of a time, of which the median; the longest runs are measured once"))
    program = Program(arguments.program, arguments.output)
    for name, measure in (("beam", beam), ("chen", chen)):
        if name in arguments.part:
            write(measure(program, arguments.repeats), name, arguments.output)


if __name__ == "__main__":
    main()
