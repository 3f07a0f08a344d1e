"""Errors that are told of K in scenes as a user writes them, in coarse cells: references by finite elements of order 6 with rings around the tips (orders 4 and 6 agree to 0.05 %)."""

import harness
import numpy as np

SCENE = """\
&run plane = '{plane}'  thickness = {thickness}  end_time = 1.0 /
&grid lower = {lower}  cell = {cell}  cells = {cells}  order = {order} /
&material name = 'a'  young = {young}  poisson = {poisson}  density = 1000.0 /
&body material = 'a'  lower = 0.0, 0.0  upper = {size}  points_per_cell = {points} /
&constraint {held}  fix = 'xy' /
{loads}
{cracks}
&method time = 'static' /
{refine}
&energy_release estimators = 'domain_integral' /
&output file = 'out.h5' /
"""
# Reference of K_I and K_II of each tip; the least side of the body is 12 to 40 cells long
SCENES = {
    "edge": (dict(plane="strain", thickness=0.02, lower="-0.001, -0.0015", cell=1e-3, cells="27, 64", order=1, young=210e9, poisson=0.35, size="0.024, 0.06", points=2,
                  held="lower = 0.024, 0.0  upper = 0.024, 0.06"), [("0.0, 0.06", "0.024, 0.06", "-199.087979, 157.872303")],
             ["0.0, 0.031145677666, 0.008334912529, 0.034230720887"], 2, [4987.4, 4272.9]),
    "inner": (dict(plane="stress", thickness=0.02, lower="-0.0026, -0.002", cell=2e-3, cells="29, 33", order=1, young=3e9, poisson=0.42, size="0.05, 0.06", points=2,
                   held="lower = 0.0, 0.0  upper = 0.05, 0.0"), [("0.008, 0.06", "0.0445, 0.06", "325.573477, -124.045131"), ("0.0, 0.0", "0.0, 0.06", "174.018033, 784.704362"),
                                                                 "-785.258523, 482.009957"],
              ["0.016702199202, 0.023220328483, 0.025693392420, 0.031503182159"], 0, [-73248, 39101, -12007, 80886]),
    "kinked": (dict(plane="strain", thickness=1.0, lower="-0.003, -0.002", cell=2e-3, cells="24, 18", order=1, young=210e9, poisson=0.3, size="0.04, 0.03", points=3,
                    held="lower = 0.0, 0.0  upper = 0.04, 0.0"), [("0.0, 0.0", "0.0, 0.03", "-27355.575197, -27203.074917"), ("0.0, 0.03", "0.04, 0.03", "-16665.407696, -31386.153691"),
                                                                  "2423.305188, -2185.791703"],
               ["0.015018573489, 0.011748919201, 0.021193084283, 0.015066162267, 0.023468376519, 0.019805142180"], 2, [1.6751e5, 12172, 35922, -1.8365e5]),
    "quadratic": (dict(plane="strain", thickness=0.005, lower="-0.002, -0.002", cell=2e-3, cells="28, 33", order=2, young=210e9, poisson=0.2, size="0.05, 0.06", points=3,
                       held="lower = 0.0, 0.0  upper = 0.05, 0.0"), [("0.003, 0.06", "0.0445, 0.06", "-11.844026, 138.533945")],
                  ["0.019971563561, 0.030201798754, 0.037276084930, 0.035799211168"], 0, [1.1679e5, 19410, 1.0935e5, 23057]),
    "quadratic edge": (dict(plane="stress", thickness=0.02, lower="-0.001, -0.001", cell=1e-3, cells="53, 43", order=2, young=210e9, poisson=0.0, size="0.05, 0.04", points=3,
                            held="lower = 0.05, 0.0  upper = 0.05, 0.04"), [("0.0, 0.0", "0.05, 0.0", "-148.910050, -620.579095")],
                       ["0.0, 0.022515334348, 0.011623697348, 0.023747893031"], 2, [54261, 30480]),
    "quadratic level": (dict(plane="strain", thickness=0.02, lower="-0.002, -0.002", cell=2e-3, cells="15, 33", order=2, young=3e9, poisson=0.3, size="0.024, 0.06", points=3,
                             held="lower = 0.0, 0.0  upper = 0.024, 0.0"), [("0.024, 0.0", "0.024, 0.06", "-974.960488, -784.231751"), ("0.0, 0.0", "0.0, 0.06", "-571.303577, -229.061622"),
                                                                            "2188.651205, 489.417697"],
                        ["0.009132929649, 0.024343168340, 0.013144402398, 0.030628881362"], 1, [1.9368e5, 60320, 1.835e5, 5236.3]),
    "quadratic mouth": (dict(plane="stress", thickness=0.005, lower="-0.001, -0.001", cell=1e-3, cells="43, 43", order=2, young=210e9, poisson=0.35, size="0.04, 0.04", points=3,
                             held="lower = 0.0, 0.0  upper = 0.04, 0.0"), [("0.0, 0.0", "0.0, 0.04", "186.849898, -4.159253")],
                        ["0.0, 0.018409260939, 0.005274471669, 0.008041606422"], 2, [-1.6664e5, -3.6122e5]),
    "two cracks": (dict(plane="strain", thickness=0.02, lower="-0.002, -0.0025", cell=2e-3, cells="15, 34", order=1, young=3e9, poisson=0.2, size="0.024, 0.06", points=2,
                        held="lower = 0.024, 0.0  upper = 0.024, 0.06"), [("0.0, 0.0", "0.024, 0.0", "-461.418356, -120.803814")],
                   ["0.009508680987, 0.040585033199, 0.014491319013, 0.043414966801", "0.009756329884, 0.019118395297, 0.014243670116, 0.016881604703"], 0,
                   [2542.5, -2852.3, 2014.3, -3677.9, 10914, -4208, -969.99, -5695.9]),
}


def test_errors_hold_what_finite_elements_find(hampm):
    """Those of version 2 held 15 of these 30. K_I of the first is 0.6 % too large by its cells far from the tip: 2.1 times its error, until that knew of them by the dual displacement of K."""
    ratios, names, of_j = [], [], []
    for name, (keys, loads, cracks, level, asked) in SCENES.items():
        lines = [f"&load kind = 'gravity'  acceleration = {load} /" if isinstance(load, str) else f"&load kind = 'traction'  lower = {load[0]}  upper = {load[1]}  force = {load[2]} /" for load in loads]
        row = harness.run(hampm, SCENE.format(**keys, loads="\n".join(lines), cracks="\n".join(f"&crack name = 'c{n}'  kind = 'path'  points = {points} /" for n, points in enumerate(cracks)),
                                              refine=f"&refine indicator = 'tip'  max_level = {level} /" if level else ""))
        for n, value in enumerate(asked):
            tip = f"_tip{n // 2 + 1}" if n > 1 else ""
            mode = "I" * (n % 2 + 1)
            found, error = row[f"K_{mode}{tip}"][-1], row[f"K_{mode}_error{tip}"][-1]
            print(f"{name} K_{mode}{tip} {found:.5g} +- {error:.2g}, right {value:.5g}: {abs(found - value) / error:.2f}")
            ratios.append(abs(found - value) / error)
            names.append(name)
            assert error < (0.4 if name == "two cracks" else 0.06) * np.max(np.abs(asked)), name
        young, poisson = float(keys["young"]), float(keys["poisson"])
        for n in range(0, len(asked), 2):
            tip = f"_tip{n // 2 + 1}" if n else ""
            right = (asked[n]**2 + asked[n + 1]**2) * (1 - poisson**2 * (keys["plane"] == "strain")) / young
            of_j.append(abs(row[f"J{tip}"][-1] - right) / row[f"J_error{tip}"][-1])
            print(f"{name} J{tip} {row[f'J{tip}'][-1]:.5g} +- {row[f'J_error{tip}'][-1]:.2g}, right {right:.5g}: {of_j[-1]:.2f}")
    ratios = np.array(ratios)
    assert np.sum(np.array(of_j) > 1) <= 1 and np.all(np.array(of_j) < 1.2) and np.median(of_j) > 0.2
    assert np.sum(ratios > 1) <= 1 and np.all(ratios < 1.1)
    assert ratios[0] > 0.3                         # that of the first is found, not covered by a wide one
    assert np.median(ratios) > 0.1                 # no wider than they have to be


MOVED = """\
&run plane = 'strain' end_time = 1.0 /
&grid lower = -0.001, -0.001 cell = 1e-3 cells = 22, 32 /
&material name = 'a' young = 200e9 poisson = 0.3 density = 7800 /
&body material = 'a' lower = 0.0, 0.0 upper = 0.02, 0.03 /
&constraint lower = 0.0, 0.0 upper = 0.02, 0.0 fix = 'xy' /
&constraint lower = 0.0, 0.03 upper = 0.02, 0.03 fix = 'xy' displacement = {moved} /
{load}
&crack kind = 'path' points = -0.001, 0.0133, 0.0083, 0.0141 /
&method time = 'static' load_steps = 1 /
&energy_release estimators = 'domain_integral' /
&output file = 'out.h5' /
"""
TRACTION = "&load kind = 'traction' lower = 0.02, 0.0 upper = 0.02, 0.03 force = {} /"


def errors_of(hampm, moved, load):
    row = harness.run(hampm, MOVED.format(moved=moved, load=load))
    return {name: row[f"{name}_error"][-1] for name in ("J", "K_I", "K_II")}, row


def test_errors_at_rest_are_of_supports_and_loads_as_they_end(hampm):
    """Supports that move were in no estimate, and loads had their largest factors, however little of them acts: what nearly cancels had the error of what does not."""
    ramped = errors_of(hampm, "4e-6, 8e-6 history = 'ramp' rise_time = 4.0", TRACTION.format("0.0, -9e4 history = 'table' times = 0.0, 0.5, 1.0 factors = 0.0, 1.0, 0.3"))[0]
    as_they_end, _ = errors_of(hampm, "1e-6, 2e-6", TRACTION.format("0.0, -2.7e4"))
    alone = errors_of(hampm, "1e-12, 2e-12", TRACTION.format("0.0, -2.7e4"))[0]
    for name, error in as_they_end.items():
        assert abs(ramped[name] - error) < 1e-6 * error
        assert abs(alone[name] - error) > 0.05 * error


def test_errors_of_moved_supports_are_no_guess_by_lengths(hampm):
    """K of cells of a quarter is right to a quarter of the error or so; by lengths K had an error of 21 % here."""
    error, row = errors_of(hampm, "0.0, 2e-6", "")
    fine = harness.run(hampm, MOVED.format(moved="0.0, 2e-6", load="").replace("cell = 1e-3 cells = 22, 32", "cell = 0.25e-3 cells = 88, 128"))
    size = np.hypot(fine["K_I"][-1], fine["K_II"][-1])
    for name in ("K_I", "K_II"):
        off = abs(row[name][-1] - fine[name][-1])
        print(name, row[name][-1], error[name], off)
        assert off < error[name] < 0.05 * size


FEW_CELLS = """\
&run plane = 'stress' end_time = 1.0 /
&grid cell = 1.0 cells = {width}, {height} /
&material name = 'a' young = 1e9 poisson = 0.3 density = 1000 /
&body material = 'a' lower = 0.0, 0.0 upper = {width}, {height} /
&constraint lower = {crack}, 0.0 upper = {width}, 0.0 fix = 'y' /
&constraint lower = {held} fix = 'x' /
&load kind = 'traction' lower = 0.0, {height} upper = {width}, {height} force = 0.0, {width}e3 /
&crack kind = 'symmetry' tip = {crack}, 0.0 /
&method time = 'static' /
&energy_release estimators = 'vcct', 'domain_integral' /
&output file = 'out.h5' /
"""
# K/(sigma sqrt(pi a)) of an edge crack (Kaya & Erdogan 1987), and of a centre crack (Tada, to 0.1 %), by kind, cells of the crack and of the (half) width
EDGE = {0.3: 1.6599, 0.4: 2.1114, 0.5: 2.8246, 0.6: 4.0332}
FEW = [("edge", 3, 5), ("edge", 3, 10), ("edge", 4, 10), ("edge", 5, 10), ("edge", 6, 20), ("centre", 3, 5), ("centre", 3, 8), ("centre", 5, 10)]


def test_errors_of_cracks_of_few_cells_know_the_second_order_of_these(hampm):
    """What J lacks by the cells at a tip is a series in cells over the crack. Its first term alone left the first of these 2.4 errors off, and four of the eight outside."""
    for kind, crack, width in FEW:
        height = (4 if kind == "edge" else 3) * width
        row = harness.run(hampm, FEW_CELLS.format(width=width, height=height, crack=crack, held=f"{width}, 0.0 upper = {width}, 0.0" if kind == "edge" else f"0.0, 0.0 upper = 0.0, {height}"))
        part = crack / width
        k = 1e3 * np.sqrt(np.pi * crack) * (EDGE[part] if kind == "edge" else (1 - 0.025 * part**2 + 0.06 * part**4) / np.sqrt(np.cos(np.pi * part / 2)))
        for name, value in (("K_I", k), ("J", k**2 / 1e9), ("G_vcct_I", k**2 / 1e9)):
            off, error = abs(row[name][-1] - value), row[f"{name}_error"][-1]
            print(kind, crack, width, name, row[name][-1] / value, error / value, off / error)
            assert off < error < 3 * off


SHORT = """\
&run plane = 'strain' end_time = 1.0 /
&grid lower = -1.0, -1.0 cell = 1.0 cells = 11, 13 /
&material name = 'a' young = 70e9 poisson = 0.25 density = 2700 /
&body material = 'a' lower = 0.0, 0.0 upper = 9.0, 11.0 /
&crack kind = 'path' points = {left}, {height}, {right}, {height} /
&constraint lower = 0.0, 0.0 upper = 9.0, 0.0 fix = 'xy' /
&constraint lower = 0.0, 11.0 upper = 9.0, 11.0 fix = 'xy' displacement = 1.7e-4, -2.7e-5 /
&method time = 'static' load_steps = 1 /
&energy_release estimators = 'domain_integral' /
&output file = 'out.h5' /
"""
# K_I and K_II of both tips by finite elements of order 4 with rings around tips (0.05 % of the size of K), by the ends of the crack and its height
SHORT_ONES = {(3.4769, 6.1961, 5.8501): [-345759, 738165, -380306, 770172], (3.6769, 6.3961, 5.7201): [-351372, 723904, -374568, 773976],
              (3.9269, 6.6461, 5.5001): [-369270, 702483, -372463, 775045], (4.1769, 6.8961, 5.3501): [-386604, 677000, -375951, 772045],
              (3.7769, 6.4961, 4.9001): [-423807, 716095, -369127, 772307]}


def test_errors_of_short_cracks_know_the_fields_beside_the_singular_one(hampm):
    """At some places K changes hardly with the place of a tip: K_I of the second one was 2.5 errors off, as discs of two cells know of nothing else. They know the next fields to the second
    order of the cells."""
    off = []
    for (left, right, height), asked in SHORT_ONES.items():
        row = harness.run(hampm, SHORT.format(left=left, right=right, height=height))
        for name, value in zip(("K_I", "K_II", "K_I_tip2", "K_II_tip2"), asked):
            error = row[name[:4].rstrip("_") + "_error" + name[len(name[:4].rstrip("_")):]][-1]
            print(height, name, row[name][-1], error, value, abs(row[name][-1] - value) / error)
            off.append(abs(row[name][-1] - value) / error)
    assert np.mean(np.array(off) > 1) <= 0.1 and max(off) < 1.5 and np.median(off) > 0.15


LONE = """\
&run plane = 'stress' end_time = 1.0 /
&grid lower = -1.0, -1.0 cell = 1.0 cells = 50, 50 /
&material name = 'a' young = 1e9 poisson = 0.3 density = 1000 /
&body material = 'a' lower = 0.0, 0.0 upper = 48.0, 48.0 points_per_cell = 1 /
&load kind = 'traction' lower = 0.0, 0.0 upper = 0.0, 48.0 force = {0}, {1} /
&load kind = 'traction' lower = 48.0, 0.0 upper = 48.0, 48.0 force = -{0}, -{1} /
&load kind = 'traction' lower = 0.0, 0.0 upper = 48.0, 0.0 force = {1}, -{0} /
&load kind = 'traction' lower = 0.0, 48.0 upper = 48.0, 48.0 force = -{1}, {0} /
&crack kind = 'path' points = {2} /
&method time = 'static' /
&energy_release estimators = 'domain_integral' /
&output file = 'out.h5' /
"""


def test_errors_of_cells_with_one_particle_know_that_faces_slide_too_far(hampm):
    """A crack in pure shear that is as if 0.5 cells longer at each tip: J was 1.2 and 1.8 errors off, K_II 2.7. By finite elements of order 4, to 0.01 %."""
    row = harness.run(hampm, LONE.format(44441.788070879746, 18136.357767286427, "20.686205813427954, 18.470922603899183, 27.713794186572045, 28.929077396100816"))
    for name, error, value in (("J", "J_error", 0.022378), ("J_tip2", "J_error_tip2", 0.0223817), ("K_I", "K_I_error", -16.6), ("K_I_tip2", "K_I_error_tip2", -10.7),
                               ("K_II", "K_II_error", 4730.65), ("K_II_tip2", "K_II_error_tip2", 4730.89)):
        print(name, row[name][-1], row[error][-1], value)
        assert abs(row[name][-1] - value) < row[error][-1]
    assert row["K_II_error"][-1] < 0.06 * 4730


BESIDE = """\
&run plane = 'stress' end_time = 1.0 thickness = 3.0 /
&grid lower = -0.25, -0.25 cell = 0.25 cells = 13, 15 /
&material name = 'a' young = 10000.0 poisson = 0.4 density = 1000.0 /
&body material = 'a' lower = 0.0, 0.0 upper = 2.75, 3.25 profile_direction = 0.0, 1.0 profile_at = 0.125, 1.625, 3.125 profile_stiffness = 2.0, 0.5, 1.0 /
&crack kind = 'path' name = 'c0' points = 0.7380299859165902, 0.6694884258552476, 0.7380299859165902, 1.5691779455294161 /
&crack kind = 'path' name = 'c1' points = 1.875, 1.667259289538313, 1.875, 2.582740710461687 /
&constraint lower = 0.0, 0.0 upper = 2.75, 0.0 fix = 'y' /
&load kind = 'pressure' on = 'crack' pressure = 0.2069845573574373 crack = 'c0' /
&method time = 'static' /
&energy_release estimators = 'domain_integral' /
&output file = 'out.h5' /
"""
OF_BESIDE = {"K_I": 0.254978, "K_II": -0.0033897, "K_I_tip2": 0.327368, "K_II_tip2": 0.0288012, "K_I_tip3": 0.0105891, "K_II_tip3": 0.00485106, "K_I_tip4": 0.00364037, "K_II_tip4": 0.0124845}


def test_errors_of_a_crack_know_the_places_of_others_as_j_does(hampm):
    """One that only another one loads is as far off as that is too short: five of its K and those of the other were up to twice their errors off. By finite elements of order 3, to 0.1 %."""
    row = harness.run(hampm, BESIDE)
    off = []
    for name, value in OF_BESIDE.items():
        quantity, _, tip = name.partition("_tip")
        off.append(abs(row[name][-1] - value) / row[f"{quantity}_error" + (f"_tip{tip}" if tip else "")][-1])
        print(name, row[name][-1], value, off[-1])
    assert max(off) < 1.25 and np.sum(np.array(off) > 1) <= 1


FIBRES = """\
&run plane = 'stress' end_time = 1.9179306759022767e-06 thickness = 1.0 /
&grid lower = -0.00830078125, -0.005480237488014824 cell = 0.0009765625 cells = 14, 13 /
&material name = 'm0' law = 'orthotropic' young_1 = 70000000000.0 young_2 = 28000000000.0 shear_12 = 14000000000.0 poisson_12 = 0.3 density = 2700.0 /
&body material = 'm0' points_per_cell = 2 lower = -0.00732421875, -0.004503674988014824 upper = 0.00439453125, 0.006238512511985176 profile_direction = 0.8660254037844387, 0.49999999999999994
 profile_at = -0.006694257519082273, -0.0008348825190822732, 0.005024492480917727 profile_stiffness = 0.5, 0.5, 1.0 profile_density = 0.7, 1.5, 1.0 /
&crack kind = 'symmetry' tip = -0.00439453125, -0.004503674988014824 /
&constraint lower = -0.00439453125, -0.004503674988014824 upper = 0.00439453125, -0.004503674988014824 fix = 'y' /
&constraint lower = -0.00732421875, 0.006238512511985176 upper = 0.00439453125, 0.006238512511985176 fix = 'xy' displacement = 5.789871963021962e-07, -2.3348988044252137e-07 /
&load kind = 'body' force = -55528.64669372212, -3295.423122159096 lower = -0.00732421875, 0.0009357781369851766 upper = 0.00439453125, 0.006238512511985176 history = 'ramp' rise_time = 3.8358613518045535e-06 /
&load kind = 'pressure' pressure = -5368113.312398996 lower = -0.00732421875, 0.006238512511985176 upper = 0.00439453125, 0.006238512511985176 history = 'table' times = 0.0, 7.671722703609107e-07, 1.9179306759022767e-06 factors = 0.0, 1.0, 0.5 /
&method time = 'static' load_steps = 1 /
&energy_release estimators = 'domain_integral' /
&output file = 'out.h5' /
"""


def test_errors_of_k_that_has_the_size_of_j_know_those_of_j(hampm):
    """As it has at a node in a material that is not isotropic: K of 850 +- 310 for 1549 beside a J of 4 % of its error, after a load that was larger before."""
    row = harness.run(hampm, FIBRES)
    k, j, error = row["K_I"][-1], row["J"][-1], row["J_error"][-1]
    print(k, j, error, row["K_I_error"][-1])
    assert row["K_I_error"][-1] >= abs(k) * (np.sqrt(1 + error / abs(j)) - 1) * (1 - 1e-9)


ALONG = """\
&run plane = 'strain' end_time = 12e-6 /
&grid lower = -2e-3, -2e-3 cell = {cell} cells = {cells} /
&material name = 'a' young = 200e9 poisson = 0.3 density = 7800 /
&body material = 'a' lower = 0.0, 0.0 upper = 40e-3, 20e-3 /
&constraint lower = 40e-3, 0.0 upper = 40e-3, 20e-3 fix = 'x' /
&constraint lower = 40e-3, 0.0 upper = 40e-3, 0.0 fix = 'xy' /
&load kind = 'traction' lower = 0.0, 0.0 upper = 0.0, 20e-3 force = -4e5, 0.0 history = 'smooth_ramp' rise_time = 6e-6 /
&crack kind = 'path' points = 12.2e-3, 10.3e-3, 20.4e-3, 10.3e-3 /
&method time = 'explicit' /
&energy_release estimators = 'domain_integral' /
&output file = 'out.h5' history_interval = 1e-6 /
"""


def test_errors_in_motion_of_a_tip_that_the_static_load_does_not_load(hampm):
    """A load along a crack has no static K: what is rounding in it told errors of 1e6 times the values that waves make. The crack and the ligament tell them."""
    coarse, fine = (harness.run(hampm, ALONG.format(cell=cell, cells=cells)) for cell, cells in (("1e-3", "44, 24"), ("0.5e-3", "88, 48")))
    for name in ("J", "J_tip2", "K_I", "K_I_tip2"):
        error = coarse[name.replace("_tip2", "") + "_error" + ("_tip2" if "tip2" in name else "")]
        print(name, np.abs(coarse[name] - fine[name]) / np.maximum(error, 1e-300), error / np.max(np.abs(fine[name])))
        assert np.mean(np.abs(coarse[name] - fine[name]) <= error) >= 0.8
        assert np.all(error <= 1.5 * np.max(np.abs(fine[name])))


TURNED = """\
&run plane = 'strain' end_time = 1.0 /
&grid lower = -1.0, -1.0 cell = 1.0 cells = 11, 13 /
&material name = 'a' young = 70e9 poisson = 0.25 density = 2700 /
&body material = 'a' lower = 0.0, 0.0 upper = 9.0, 11.0 /
&crack kind = 'path' points = 3.4769, 5.8501, 6.1961, 6.6501 /
&constraint lower = 0.0, 0.0 upper = 0.0, 0.0 fix = 'xy' /
&constraint lower = 9.0, 0.0 upper = 9.0, 0.0 fix = 'y' displacement = 0.0, {lifted} /
&load kind = 'traction' lower = 0.0, 11.0 upper = 9.0, 11.0 force = 2e6, 9e6 /
&load kind = 'traction' lower = 0.0, 0.0 upper = 9.0, 0.0 force = -2e6, -9e6 /
&load kind = 'traction' lower = 9.0, 0.0 upper = 9.0, 11.0 force = 0.0, 2.4e6 /
&load kind = 'traction' lower = 0.0, 0.0 upper = 0.0, 11.0 force = 0.0, -2.4e6 /
&method time = 'static' load_steps = 1 /
&energy_release estimators = 'domain_integral' /
&output file = 'out.h5' /
"""


def test_errors_are_those_of_the_body_however_it_is_turned(hampm):
    """A support that moves turns the body by 1e-4 and strains nothing. The discs that tips move in were strained by it: errors of K were 10 times as wide, and 17 times for -2e-4."""
    still, *turned = (harness.run(hampm, TURNED.format(lifted=lifted)) for lifted in ("0.0", "1e-3", "-2e-3"))
    for name in ("J", "K_I", "K_II"):
        for tip in ("", "_tip2"):
            for row in turned:
                assert abs(row[name + tip][-1] / still[name + tip][-1] - 1) < 1e-6
                assert abs(row[f"{name}_error{tip}"][-1] / still[f"{name}_error{tip}"][-1] - 1) < 0.1
