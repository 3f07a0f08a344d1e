"""Scenes that random ones (`combinations.py`, most with `--cracked`) found to hang on a mirror or on the order of points: their histories are to be the same to 1e-9."""

import combinations
import pytest
from paths import CHECKED_PROGRAM, SOLID_PROGRAM

SCENES = {
    "lengths of vectors in other units, and a tip that runs": ("bits", [
        ["run", {"plane": "strain", "end_time": 3.7e-06, "thickness": 1.0}],
        ["grid", {"lower": [-0.00830078125, 0.006232323231032573], "cell": 0.0009765625, "cells": [14, 15]}],
        ["material", {"name": "m0", "young": 70e9, "poisson": 0.3, "density": 2700.0}],
        ["body", {"material": "m0", "lower": [-0.00732421875, 0.007208885731032573], "upper": [0.004150390625, 0.019611229481032572], "velocity": [0.0355, 0.0167]}],
        ["body", {"hole": True, "shape": "circle", "center": [0.0012, 0.0161], "radius": 0.0017}],
        ["crack", {"kind": "line", "name": "c0", "tip": [-0.00341796875, 0.011115135731032573], "direction": [1.0, 0.0], "length": 0.001953125}],
        ["growth", {"law": "prescribed", "direction": "max_energy", "crack": "c0", "tips": "last", "speed": 1018.0, "max_length": 0.0078125}],
        ["constraint", {"lower": [-0.00732421875, 0.007208885731032573], "upper": [-0.00732421875, 0.007208885731032573], "fix": "xy"}],
        ["constraint", {"lower": [0.00439453125, 0.007208885731032573], "upper": [0.00439453125, 0.007208885731032573], "fix": "y"}],
        ["method", {"time": "explicit"}],
        ["energy_release", {"estimators": ["domain_integral"], "energy_balance": True}],
        ["output", {"file": "case.h5", "history_interval": 3.7e-07}],
    ]),
    "a closed tip that slides either way": ("mirror in x", [
        ["run", {"plane": "strain", "end_time": 4.3223090711018e-06, "thickness": 3.0}],
        ["grid", {"lower": [0.0029296875, 0.0], "cell": 0.0009765625, "cells": [9, 12]}],
        ["material", {"name": "m0", "law": "linear_elastic", "young": 70000000000.0, "poisson": 0.0, "density": 2700.0}],
        ["body", {"material": "m0", "points_per_cell": 2, "lower": [0.0029296875, 0.0], "upper": [0.01171875, 0.01171875], "velocity": [0.024037113069869696, -0.02806834751357469]}],
        ["crack", {"kind": "line", "contact": "frictionless", "tip": [0.0078125, 0.0048828125], "direction": [0.0, 1.0], "length": 0.001953125}],
        ["constraint", {"lower": [0.0029296875, 0.0], "upper": [0.0029296875, 0.0], "fix": "xy", "name": "a"}],
        ["constraint", {"lower": [0.01171875, 0.0], "upper": [0.01171875, 0.0], "fix": "y", "name": "b"}],
        ["load", {"kind": "point", "force": [0.0, 3781.720368886139], "lower": [0.00732421875, 0.01171875], "upper": [0.00732421875, 0.01171875], "history": "sine", "frequency": 69407.34571846038, "start": -4.3223090711018004e-07}],
        ["load", {"kind": "gravity", "acceleration": [-250.88209594470422, -22885.82525473374]}],
        ["method", {"time": "explicit", "scheme": "musl"}],
        ["refine", {"indicator": "tip", "max_level": 2, "max_particles": 4000, "rings": 2}],
        ["energy_release", {"estimators": ["domain_integral"]}],
        ["output", {"file": "case.h5", "history_interval": 1.08057726777545e-06}],
    ]),
    "friction on the mesh of the first state": ("mirror in y", [
        ["run", {"plane": "strain", "end_time": 1.9639610121239313e-06, "thickness": 0.01}],
        ["grid", {"lower": [0.0, -0.0075], "cell": 0.001, "cells": [12, 13]}],
        ["material", {"name": "m0", "law": "linear_elastic", "young": 70000000000.0, "poisson": 0.0, "density": 2700.0}],
        ["body", {"material": "m0", "points_per_cell": 1, "lower": [0.0, -0.0075], "upper": [0.0115, 0.0055], "eigenstrain": [-0.00020865973335164252, 0.00012274402588049923, 0.0003617694848275773],
                  "profile_direction": [0.8660254037844387, 0.49999999999999994], "profile_at": [-0.001303847577293367, 0.004696152422706633, 0.010696152422706634],
                  "profile_stiffness": [2.0, 2.0, 2.0], "profile_eigenstrain": [0.2251964494112333, 0.11878772785970249, 0.32987148371732444]}],
        ["crack", {"kind": "path", "name": "c0", "points": [0.0022020389970523867, -0.003125028080559676, 0.005386631208734411, -0.003125028080559676], "contact": "frictionless"}],
        ["crack", {"kind": "path", "name": "c1", "points": [0.007415403465029805, -8.45965349701956e-05, 0.009584596534970196, 0.0020845965349701955], "contact": "friction", "friction": 0.7}],
        ["method", {"time": "static", "load_steps": 1}],
        ["refine", {"indicator": "gradient", "max_level": 1, "max_particles": 4000, "field": "stress_norm"}],
        ["energy_release", {"estimators": ["domain_integral"], "energy_balance": True}],
        ["output", {"file": "case.h5"}],
    ]),
    "particles on the line ahead of a tip": ("mirror in y", [
        ["run", {"plane": "stress", "end_time": 0.0013277586906449191, "thickness": 3.0}],
        ["grid", {"lower": [0.5, -0.25], "cell": 0.25, "cells": [13, 12], "order": 1}],
        ["material", {"name": "m0", "law": "linear_elastic", "young": 3000000000.0, "poisson": 0.4, "density": 1200.0}],
        ["body", {"material": "m0", "points_per_cell": 4, "lower": [0.875, 0.0], "upper": [3.4375, 2.5], "eigenstrain": [0.00014576894591996495, 0.0001755407083322703, 0.0]}],
        ["crack", {"kind": "path", "name": "c0", "points": [1.75, 1.0, 2.0, 1.5, 2.25, 1.75], "contact": "none"}],
        ["constraint", {"lower": [0.75, 0.0], "upper": [3.5, 0.0], "fix": "xy"}],
        ["constraint", {"lower": [0.75, 2.5], "upper": [3.5, 2.5], "fix": "xy", "velocity": [-0.35888080989767274, -0.6761872162690927], "name": "a"}],
        ["load", {"kind": "point", "force": [1683727.9684881791, -1665634.2362220564], "lower": [2.125, 2.5], "upper": [2.125, 2.5]}],
        ["method", {"time": "explicit", "scheme": "musl", "mass": "consistent", "solver": "direct"}],
        ["refine", {"indicator": "tip", "max_level": 1, "max_particles": 4000, "rings": 4}],
        ["energy_release", {"estimators": ["domain_integral"]}],
        ["output", {"file": "case.h5", "history_interval": 0.00018967981294927417}],
    ]),
    "cohesion all along from a hole": ("reverse", [
        ["run", {"plane": "axisymmetric", "end_time": 9.255260126692795e-06}],
        ["grid", {"lower": [0.019, 0.0030919120612231837], "cell": 0.001, "cells": [13, 13]}],
        ["material", {"name": "m0", "law": "viscoelastic", "young": 3000000000.0, "poisson": 0.3, "density": 1200.0, "moduli": [300000000.0, 150000000.0], "relaxation_times": [4.6276300633463974e-07, 9.255260126692795e-06]}],
        ["body", {"material": "m0", "points_per_cell": 2, "lower": [0.02, 0.004091912061223184], "upper": [0.031, 0.015091912061223184], "velocity": [0.11993377709856598, -0.019531613876957725]}],
        ["body", {"hole": True, "shape": "circle", "center": [0.024829974350334204, 0.008897111785090497], "radius": 0.002173403548324349, "points_per_cell": 1}],
        ["crack", {"kind": "path", "name": "c1", "points": [0.026100800204255648, 0.010284083682500113, 0.028899199795744353, 0.011899740439946255], "contact": "friction", "friction": 0.2}],
        ["cohesive", {"law": "linear", "strength": 717981.0451879007, "toughness": 0.910750961606402, "crack": "c1"}],
        ["constraint", {"lower": [0.019, 0.0035919120612231837], "upper": [0.032, 0.005291912061223184], "fix": "xy", "name": "a"}],
        ["constraint", {"lower": [0.02, 0.015091912061223184], "upper": [0.031, 0.015091912061223184], "fix": "xy", "displacement": [-2.800538196021692e-07, 5.582736635702179e-07], "history": "sine", "frequency": 32413.999811283506, "name": "b"}],
        ["load", {"kind": "pressure", "pressure": 229002.83395926908, "lower": [0.019, 0.009591912061223184], "upper": [0.032, 0.016091912061223183]}],
        ["method", {"time": "explicit", "scheme": "usavg", "mass": "weighted", "solver": "auto"}],
        ["energy_release", {}],
        ["output", {"file": "case.h5", "history_interval": 9.255260126692795e-07}],
    ]),
    "what tractions behind a closed tip bear beside their line": ("reverse", [
        ["run", {"plane": "stress", "end_time": 1.0220007753063795, "thickness": 0.01}],     # faces that slide part then, and rounding tells when
        ["grid", {"lower": [0.0, -0.22499999999999998], "cell": 0.03, "cells": [14, 13]}],
        ["material", {"name": "spare", "law": "mooney_rivlin", "young": 10000.0, "poisson": 0.49, "density": 1000.0, "c01": 1677.8523489932886}],
        ["material", {"name": "m0", "law": "neo_hookean", "young": 10000.0, "poisson": 0.49, "density": 2000.0}],
        ["body", {"material": "m0", "points_per_cell": 3, "lower": [0.0, -0.22499999999999998], "upper": [0.42, 0.16499999999999998], "spin": 0.000366289674655246}],
        ["crack", {"kind": "path", "name": "c0", "points": [0.09071298584415177, -0.12981253573049095, 0.18374762107420742, -0.05815965551954415], "contact": "friction", "friction": 0.7}],
        ["crack", {"kind": "path", "name": "c1", "points": [0.34125, -0.0075, 0.25875, 0.0375], "contact": "none"}],
        ["constraint", {"lower": [0.0, -0.22499999999999998], "upper": [0.42, -0.22499999999999998], "fix": "y", "unilateral": True}],
        ["load", {"kind": "gravity", "acceleration": [0.0, 0.0003592046989886401]}],
        ["method", {"time": "implicit", "time_step": 0.06813338502042529, "hht_alpha": -0.1, "mass": "lumped", "solver": "auto"}],
        ["energy_release", {"estimators": ["domain_integral"]}],
        ["output", {"file": "case.h5", "history_interval": 0.3406669251021265}],
        ["damping", {"rate": 1.0540925533894598}],
    ]),
    "faces behind a tip that meet a kink": ("mirror in x", [
        ["run", {"plane": "strain", "end_time": 0.00011274653014995527, "thickness": 1.0}],
        ["grid", {"lower": [0.13127095829387936, -0.09], "cell": 0.03, "cells": [16, 17]}],
        ["material", {"name": "m0", "law": "neo_hookean", "young": 70000000000.0, "poisson": 0.3, "density": 5400.0}],
        ["body", {"material": "m0", "points_per_cell": 4, "lower": [0.22127095829387936, 0.0], "upper": [0.5212709582938794, 0.32999999999999996], "spin": 18.161366782503443}],
        ["crack", {"kind": "path", "name": "c0", "points": [0.2812709582938794, 0.09, 0.31127095829387935, 0.15, 0.3412709582938794, 0.15], "contact": "frictionless"}],
        ["crack", {"kind": "path", "name": "c1", "points": [0.41627095829387933, 0.17099760806476785, 0.41627095829387933, 0.24900239193523213], "contact": "friction", "friction": 0.7}],
        ["constraint", {"lower": [0.22127095829387936, 0.0], "upper": [0.5212709582938794, 0.0], "fix": "xy", "name": "a"}],
        ["constraint", {"lower": [0.22127095829387936, 0.32999999999999996], "upper": [0.5212709582938794, 0.32999999999999996], "fix": "y", "displacement": [0.0, 5.663321019827875e-05], "history": "table", "times": [0.0, 4.509861205998211e-05, 0.00011274653014995527], "factors": [0.0, 1.0, -0.5], "name": "b"}],
        ["load", {"kind": "pressure", "pressure": -57525336.532093234, "lower": [0.22127095829387936, 0.32999999999999996], "upper": [0.5212709582938794, 0.32999999999999996], "history": "table", "times": [0.0, 4.509861205998211e-05, 0.00011274653014995527], "factors": [0.0, 1.0, 1.0]}],
        ["method", {"time": "explicit", "frame": "updated", "scheme": "usl"}],
        ["refine", {"indicator": "gradient", "max_level": 1, "max_particles": 4000, "interval": 5, "field": "energy_density"}],
        ["energy_release", {"energy_balance": True}],
        ["output", {"file": "case.h5", "history_interval": 1.6106647164279324e-05}],
    ]),
    "what holds nearly empty cells of usl where the mesh changes": ("mirror in x", [
        ["run", {"plane": "strain", "end_time": 2.265034864886623, "thickness": 1.0}],
        ["grid", {"lower": [-1.0, -1.0], "cell": 1.0, "cells": [14, 11]}],
        ["material", {"name": "m0", "law": "linear_elastic", "young": 10000.0, "poisson": 0.3, "density": 1000.0}],
        ["body", {"material": "m0", "points_per_cell": 2, "shape": "polygon", "points": [9.69068268761609, 5.517647887546836, 4.882562508703911, 7.935638416977373, 2.594037098942347, 3.8946221235189835, 2.158306181846657, 3.6981209490854448, 3.2438863434466416, 2.948190526497032, 8.032375216632756, 1.6675868495810628, 8.89360472769242, 3.7158226340867535], "velocity": [-0.0002457185863798664, 0.00021630299725930333], "eigenstrain": [0.0002885392398561005, -0.00036759186171835055, 0.00042363367728283233]}],
        ["constraint", {"lower": [-1.0, -0.5], "upper": [13.0, 1.2], "fix": "y", "name": "a"}],
        ["load", {"kind": "body", "force": [0.0, 39.38799879519205], "lower": [0.0, 4.57], "upper": [12.0, 9.0], "history": "ramp", "rise_time": 4.530069729773246}],
        ["method", {"time": "explicit", "scheme": "usl", "mass": "weighted", "solver": "cg"}],
        ["refine", {"indicator": "zz", "max_level": 2, "max_particles": 4000, "interval": 5, "tolerance": 0.2, "region_lower": [1.0, 1.0], "region_upper": [11.0, 8.0]}],
        ["energy_release", {"energy_balance": True}],
        ["output", {"file": "case.h5", "history_interval": 0.3235764092695176}],
    ]),
    "a load on a support, before anything else moves": ("quarter turn", [
        ["run", {"plane": "strain", "end_time": 5.854825050692838e-05, "thickness": 1.0}],
        ["grid", {"lower": [0.0, -0.22499999999999998], "cell": 0.03, "cells": [10, 11], "order": 2}],
        ["material", {"name": "m0", "law": "orthotropic", "young_1": 70000000000.0, "young_2": 28000000000.0, "young_3": 21000000000.0, "shear_12": 14000000000.0, "poisson_12": 0.3, "poisson_13": 0.2, "poisson_23": 0.25, "angle": 90.0, "density": 2700.0}],
        ["body", {"material": "m0", "points_per_cell": 4, "lower": [0.0, -0.22499999999999998], "upper": [0.3, 0.105]}],
        ["constraint", {"lower": [0.12, -0.22499999999999998], "upper": [0.3, -0.22499999999999998], "fix": "y", "name": "plane"}],
        ["constraint", {"lower": [0.0, 0.105], "upper": [0.3, 0.105], "fix": "y", "displacement": [0.0, -3.4663808344308807e-06], "history": "sine", "frequency": 17079.92965360534, "start": 1.7564475152078514e-05, "name": "a"}],
        ["load", {"kind": "point", "force": [0.0, 259114.60461909478], "lower": [0.15, 0.105], "upper": [0.15, 0.105]}],
        ["method", {"time": "explicit", "scheme": "usl"}],
        ["refine", {"indicator": "zz", "max_level": 1, "max_particles": 4000, "interval": 5, "tolerance": 0.1}],
        ["energy_release", {"estimators": [], "energy_balance": True}],
        ["output", {"file": "case.h5", "history_interval": 1.4637062626732095e-05}],
    ]),
}


@pytest.mark.parametrize("name", SCENES)
def test_images_are_the_same(name):
    oracle, scene = SCENES[name]
    bench = combinations.Bench(CHECKED_PROGRAM, exact=True)
    base = bench.run(scene)
    assert base.code == 0, base.said
    assert combinations.ask(bench, scene, base, oracle, "1") == "passed"


# A shock in a block, into which cells refine and behind which they recombine; one end of it is pulled aside
SHOCK = [
    ["run", {"end_time": 6e-5}],
    ["grid", {"lower": [0.0, 0.0, 0.0], "cell": 0.0625, "cells": [9, 4, 4]}],
    ["material", {"name": "a", "young": 70e9, "poisson": 0.3, "density": 2700.0}],
    ["body", {"material": "a", "lower": [0.0, 0.0, 0.0], "upper": [0.5, 0.25, 0.1875], "velocity": [0.3, 0.1, -0.2]}],
    ["constraint", {"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.25, 0.1875], "fix": "xyz"}],
    ["load", {"kind": "traction", "force": [2e4, 1e5, -3e4], "lower": [0.5, 0.0, 0.0], "upper": [0.5, 0.25, 0.1875]}],
    ["method", {"time": "explicit"}],
    ["refine", {"indicator": "gradient", "field": "speed", "r_crit": 0.05, "r_coarsen": 0.02, "max_level": 1, "interval": 3}],
    ["energy_release", {"energy_balance": True}],
    ["output", {"file": "case.h5", "history_interval": 2e-5}],
]


@pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")
def test_solids_in_other_units_have_the_same_bits():
    bench = combinations.Bench(SOLID_PROGRAM, exact=True)
    base = bench.run(SHOCK)
    assert base.code == 0, base.said
    assert base.row["cells"].max() > base.row["cells"][0] and combinations.ask(bench, SHOCK, base, "bits", "1") == "passed"
