"""Which time steps a mesh that is refined around a crack tip allows (docs/explanation/time_step.md): two tables, each with its CSV file.

    limit    largest stable courant number on a refined mesh of the double cantilever beam and on uniform cells, by bisection
    drift    bodies that drift into finer cells

Run by `make -C bench adaptivity`, or alone: .venv/bin/python bench/refined_meshes.py limit
"""

from mass_matrices import KINDS, SCHEMES, bisect, drift, group, mass_settings
from program_runs import Program, Unstable
from tables import ROOT, command_line, write

CASE = ROOT / "tests/regression/dcb_refined/case.nml"
SHEAR_SPEED = (70e9 / 2.6 / 2700) ** 0.5


def mesh(cell, levels=0, rings=4):
    """Settings of a beam of root cells of a size in mm, refined around the tip or uniform."""
    columns = round(100 / cell)
    settings = [f"grid.cell={cell}e-3", f"grid.cells={columns},{columns // 10 + 1}"]
    if levels == 0:
        return settings + ["refine.indicator=none"]
    return settings + [f"refine.max_level={levels}", f"refine.rings={rings}"]


def method(kind, **more):
    """Settings of a mass matrix such as 'fmpm 4', and others of &method."""
    keys = mass_settings(kind, (0, 0, 0.05, 0.01)) | more
    if kind == "partial":
        keys = {key: value for key, value in keys.items() if not key.startswith("consistent_")} | {"consistent_region": "refined"}
    return [f"method.{key}={value}" for key, value in keys.items()]


def limit_of(program, settings, finest, guess):
    """Largest stable courant number of the shear wave for the beam without damping, `finest` being the smallest cell in mm, over 2000 steps."""
    def is_stable(courant):
        end = 2000 * courant * finest * 1e-3 / SHEAR_SPEED
        try:
            program(CASE, [*settings, "damping.rate=0", "method.courant=0", f"run.end_time={end}", f"output.history_interval={end / 20}"], forced=courant)
        except Unstable:
            return False
        return True
    return bisect(is_stable, guess)


def limit(program):
    rows = [("mass", "scheme", "uniform, total", "refined, total", "refined/uniform", "over the default", "refined, updated",
             "over the default")]
    guesses = {"lumped": 1.0, "fmpm 2": 0.65, "fmpm 4": 0.43, "weighted 0.5": 0.7, "partial": 0.26, "consistent": 0.26}
    for kind in KINDS:
        for scheme in SCHEMES:
            settings = method(kind, scheme=scheme)
            total = [*settings, "method.frame=total"]
            guess = guesses[kind]
            uniform = None if kind == "partial" else limit_of(program, [*mesh(2.5), *total], 2.5, guess)
            refined = limit_of(program, [*mesh(5, 3), *total], 0.625, guess)
            updated = limit_of(program, [*mesh(5, 3), *settings], 0.625, refined)
            default = 0.05 if kind in ("consistent", "partial") else 0.1
            rows.append((kind, scheme, "" if uniform is None else f"{uniform:.3f}", f"{refined:.3f}",
                         "" if uniform is None else f"{refined / uniform:.3f}", f"{refined / 0.1:.2f}", f"{updated:.3f}",
                         f"{updated / default:.2f}"))
    return rows


def drifts(program):
    """The blocks of `drift`, whose cells refine by two levels where 7 < x < 14."""
    finer = group("refine", indicator="'gradient'", r_crit=1e-9, r_coarsen=1e-10, energy_floor=0.0, max_level=2, region_lower="7, 0", region_upper="14, 20")
    rows = [("mass", "courant", *SCHEMES)]
    for kind in KINDS:
        keys = {"mass": "'partial'", "consistent_region": "'refined'"} if kind == "partial" else mass_settings(kind, None)
        for courant in (0.1, 0.05):
            rows.append((kind, courant, *(drift(program, keys | {"scheme": f"'{scheme}'", "courant": courant}, finer) for scheme in SCHEMES)))
    return rows


def main():
    arguments = command_line(__doc__, ["limit", "drift"], "results/adaptivity")
    program = Program(arguments.program, arguments.output)
    if "limit" in arguments.part:
        write(limit(program), "limit", arguments.output)
    if "drift" in arguments.part:
        write(drifts(program), "drift", arguments.output)


if __name__ == "__main__":
    main()
