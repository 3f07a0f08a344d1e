"""Cracks at rest, at random: paths of one to three cracks with each kind of contact, and their growth by increments; lines and symmetry planes in
bilinear and quadratic cells; laws, loads, supports that only push, refinement and solvers.

Every run has to end with exit code 0, 2 or 3 as those of `runs.py` do; one that ends with 0 has finite numbers, stores no energy below 0 and, where the law is
linear and no crack grows, what the loads have done. A crack that grows has the toughness at one tip at least, or takes load cycles, and does not become shorter.

    .venv/bin/python tests/fuzz/rest_scenes.py --cases 1000 --seed 2 --program build/checked/hampm
"""

import h5py
import numpy as np
from growth_scenes import crack, resistance
from scene_fuzzer import main
from scene_maps import ends_with_its_tip

CLOSED = 1e-8  # part of the largest energy that may be missing
HELD = 1e-6  # part of the toughness by which G may differ from it
SOUGHT = 3e-6  # the same where the factor of the loads is found by trials to 1e-6, with friction and supports that only push
NOTHING = 1e-20  # an energy that is rounding [J]
LAWS = {
    "linear_elastic": "young = 200e9  poisson = {nu}",
    "neo_hookean": "young = 200e9  poisson = {nu}",
    "orthotropic": "young_1 = 140e9  young_2 = 10e9  young_3 = 10e9  shear_12 = 5e9  poisson_12 = 0.3  poisson_13 = 0.3  poisson_23 = 0.4  angle = {angle}",
    "j2_plastic": "young = 200e9  poisson = {nu}  yield_stress = 2e7  hardening = 1e9",
    "viscoelastic": "young = 200e9  poisson = {nu}  moduli = 2e10  relaxation_times = 0.3",
}


def growth(chance, cell):
    """How the crack grows, by the group's own name where there is one crack, else each by its name."""
    direction = chance.choice(["straight", "hoop_stress", "local_symmetry", "max_energy"])
    if chance.random() < 0.3:
        return (f"law = 'fatigue'  direction = '{direction}'  increment = {chance.choice([2.5, 4]) * cell:.4g}e-3  rate_constant = {10 ** chance.uniform(-28, -24):.3g}  "
                f"rate_exponent = {chance.choice([2, 3])}  threshold = {chance.choice([0, 0, 1e3, 1e5])}"
                + (f"  toughness = {10 ** chance.uniform(2, 5):.3g}" + resistance(chance, moves=False)) * (chance.random() < 0.5))
    if chance.random() < 0.2:
        rate = chance.choice([f"rate = 'charles'  rate_exponent = {chance.choice([2, 12])}  speed", f"rate = 'toughness'  exponent = {chance.choice([1, 2])}  limit_speed"])
        return (f"law = 'subcritical'  direction = '{direction}'  increment = {chance.choice([2.5, 4]) * cell:.4g}e-3  {rate} = {10 ** chance.uniform(-4, 0):.3g}  "
                f"toughness = {10 ** chance.uniform(-1, 3):.3g}" + resistance(chance, moves=False))
    text = (f"law = 'quasi_static'  direction = '{direction}'  toughness = {10 ** chance.uniform(-1, 3):.3g}  increment = {3 * cell:.4g}e-3  "
            f"tips = '{chance.choice(['all', 'largest', 'largest'])}'" + resistance(chance, moves=False))
    return text + (f"  max_length = {chance.uniform(4, 12):.3g}e-3" if chance.random() < 0.2 else "")


def cracks(chance, cell, side, grows, order):
    """The text of the cracks, and of their growth."""
    kind = "path" if grows else chance.choice(["line", "symmetry"]) if order == 2 else chance.choice(["path", "path", "line", "symmetry"])
    if kind == "symmetry":
        tip = chance.randint(-4, 4) * cell
        return (f"&crack kind = 'symmetry'  tip = {tip:.6g}e-3, {-side}e-3 /\n"
                f"&constraint lower = {tip:.6g}e-3, {-side}e-3  upper = {side}e-3, {-side}e-3  fix = 'y' /\n")
    if kind == "line":
        length = f"  length = {chance.randint(2, 5) * cell:.6g}e-3" if chance.random() < 0.5 else ""
        contact = chance.choice(["none", "frictionless"]) if order == 1 else "none"
        return (f"&crack kind = 'line'  tip = {chance.randint(0, 3) * cell:.6g}e-3, {chance.randint(-3, 3) * cell:.6g}e-3  "
                f"direction = {chance.choice(['1.0, 0.0', '0.0, 1.0', '-1.0, 0.0'])}{length}  contact = '{contact}' /\n")
    number = chance.choice([1, 1, 2, 3])
    places = {1: [(0, 0)], 2: [(-4.5, -1), (4.5, 1)], 3: [(-5, -3), (5, -3), (0, 5)]}[number]
    text, law = "", growth(chance, cell)
    for k, place in enumerate(places):
        line = crack(chance, k, np.array(place) + [chance.uniform(-0.5, 0.5), chance.uniform(-0.5, 0.5)], 3 if number == 1 else 2)
        if chance.random() < 0.2:
            line = line.replace("'frictionless'", "'friction'  friction = 0.3")
        text += line
        if grows and (k == 0 or chance.random() < 0.6):
            text += f"&growth crack = 'c{k}'  {law} /\n"
    return text


def scene(chance):
    """A plate of about 20 by 20 mm, pulled, pressed, sheared or moved."""
    grows, order = chance.random() < 0.4, chance.choice([1, 1, 1, 2])
    order = 1 if grows else order
    cell = chance.choice([0.5, 0.7, 1.0])
    n = 2 * round(10 / cell)
    side = n * cell / 2
    law = "linear_elastic" if grows else chance.choice(["linear_elastic", "orthotropic"] if order == 2 else ["linear_elastic", *LAWS])
    keys = LAWS[law].format(nu=chance.choice([0.0, 0.3, 0.45]), angle=chance.choice([0, 30]))
    steps = chance.choice([1, 3, 6]) if grows or law != "linear_elastic" else chance.choice([1, 2])
    history = chance.choice(["", "", "history = 'ramp'  rise_time = 0.7"])  # which has no place in load cycles: such scenes are refused
    indicator = chance.choice(["none", "none", "tip", "zz"])
    text = f"""&run plane = '{chance.choice(["strain", "stress"])}'  thickness = {chance.choice([1, 1e-2])}  end_time = 1.0 /
&grid lower = {-side:.6g}e-3, {-side - cell:.6g}e-3  cell = {cell}e-3  cells = {n}, {n + 2}  order = {order} /
&material name = 'a'  law = '{law}'  density = 8000  {keys} /
&body material = 'a'  lower = {-side:.6g}e-3, {-side:.6g}e-3  upper = {side:.6g}e-3, {side:.6g}e-3  points_per_cell = {3 if order == 2 else 2} /
&method time = 'static'  load_steps = {steps}  solver = '{chance.choice(["auto", "direct", "direct", "cg"])}' /
&refine indicator = '{indicator}'  max_level = {chance.choice([1, 2])}  rings = 4  tolerance = 0.05  max_particles = 30000 /
&energy_release estimators = 'domain_integral'  t_stress = {chance.choice(['.true.', '.false.'])}  energy_balance = {".true." if chance.random() < 0.5 else ".false."} /
&output file = 'case.h5' /
"""
    edge = f"lower = {-side:.6g}e-3, {side:.6g}e-3  upper = {side:.6g}e-3, {side:.6g}e-3"
    low = f"lower = {-side:.6g}e-3, {-side:.6g}e-3  upper = {side:.6g}e-3, {-side:.6g}e-3"
    force = chance.choice([(0, 100), (0, 100), (50, 20), (0, -100), (30, -50)])
    scale = chance.choice([10, 100, 1e4])
    text += cracks(chance, cell, side, grows, order)
    symmetric = "'symmetry'" in text
    if chance.random() < 0.3:
        text += f"&constraint {edge}  fix = 'y'  displacement = 0.0, {chance.choice([1e-6, -1e-6, 1e-4])}  {history} /\n"
    else:
        text += f"&load kind = 'traction'  {edge}  force = {force[0] * scale:g}, {force[1] * scale:g}  {history} /\n"
        if chance.random() < 0.3 and not symmetric:
            text += f"&load kind = 'traction'  {low}  force = {-force[0] * scale:g}, {-force[1] * scale:g}  {history} /\n"
    if grows and chance.random() < 0.4:
        text += f"&load kind = 'traction'  {edge}  force = {chance.choice([0, 300, -300])}, {chance.choice([-1000, 100, 1000])}  held = .true. /\n"
    if not symmetric and chance.random() < 0.7:
        push = "  unilateral = .true." if chance.random() < 0.15 and order == 1 else ""
        text += f"&constraint {low}  fix = '{'y' if push else chance.choice(['y', 'xy'])}'{push} /\n"
    if "'path'" in text and "c1" not in text and chance.random() < 0.2:
        text += f"&load kind = 'pressure'  on = 'crack'  pressure = {chance.choice([1e6, -1e5])}  {history} /\n"
    return text


def look(folder, text):
    """What is wrong with a result; '' where nothing is."""
    with h5py.File(folder / "case.h5") as file:
        row = {name: values[:] for name, values in file["history"].items()}
        warnings = file["history"].attrs.get("warnings", "")
    bad = [name for name, values in row.items() if not np.all(np.isfinite(values)) and not ends_with_its_tip(name, values, warnings)]
    if bad:
        return f"{bad[0]} is not finite"
    largest = max(np.max(np.abs(row["strain_energy"])), np.max(np.abs(row["external_work"])), NOTHING)
    # The work of a load that does not move its place as it grows is exact for the linear law; that of others is of the second order in the step
    if ("'linear_elastic'" in text or "'orthotropic'" in text) and "&growth" not in text and "'friction'" not in text:
        inside = row["strain_energy"] + row.get("numerical_loss", 0)
        missing = np.max(np.abs(row["external_work"] - inside)) / largest
        if not missing < CLOSED and ("numerical_loss" in row or "indicator = 'none'" in text):
            return f"{missing:.1e} of the energy is missing"
    if np.any(row["strain_energy"] < -1e-12 * largest):
        return "the strain energy is below 0"
    lengths = [values for name, values in row.items() if name.startswith("crack_length")]
    if any(np.any(np.diff(values) < -1e-12) for values in lengths):
        return "a crack has become shorter"
    if "cycles" in row:
        if np.any((np.diff(row["cycles"]) <= 0) & np.any(np.diff(lengths) > 0, axis=0)):
            return "a crack has grown in no load cycle"
    elif "&growth" in text and "load_factor" in row:
        g = np.array([row.get(f"G_kink{name[9:]}", row[f"G{name[9:]}"]) / values for name, values in row.items() if name == "toughness" or name.startswith("toughness_tip")])
        grew = np.any(np.diff(lengths) > 0, axis=0)
        off = np.nanmin(np.abs(g - 1), axis=0)[:-1][grew]
        if np.any(off > (SOUGHT if "'friction'" in text or "unilateral" in text else HELD)):
            return f"a crack has grown from where G was {np.max(off):.1e} off the toughness"
    return ""


if __name__ == "__main__":
    main(__doc__, scene, look)
