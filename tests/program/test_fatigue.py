"""Growth in load cycles: lives against closed integrations, laws of the rate, thresholds, blocks, overloads, tips with rates of their own, fracture.

K of the plates is that of a boundary collocation (tools/references/fatigue_reference.py; Tada, Paris & Irwin agree to 0.15 %)."""

import numpy as np
import pytest
from paths import BENCH

from harness import differing, run

INPUT = BENCH.parent / "input"
C, M, RANGE, LARGEST, YOUNG = 1e-29, 3.0, 90e6, 100e6, 200e9  # of fatigue_centre_crack.nml: m/cycle, -, Pa, Pa, Pa
COARSE = ("refine.max_level=2",)
SHORT = (*COARSE, "method.load_steps=4", "run.end_time=4")  # where both numbers are of the same cells, or K is taken from the run


def reference(name):
    return np.genfromtxt(BENCH.parent / "tests" / "reference" / "growth" / name, delimiter=",", skip_header=2, unpack=True)


def intensity():
    """K over stress of the half length of the crack in the middle."""
    a, k, _ = reference("g1_fatigue_centre_crack.csv")
    return np.polynomial.Polynomial.fit(a * 1e-3, k, 8)


def of_run(row):
    """The same as a run has found it: what is left between both is the error of its cycles alone."""
    return np.polynomial.Polynomial.fit(row["crack_length"], row["K_I"] / LARGEST, 8)


def cycles(rate, first, last, parts=20000):
    """Closed integration: the cycles for a way at da/dN = rate(a)."""
    a = first + (np.arange(parts) + 0.5) / parts * (last - first)
    return np.sum(1 / rate(a)) * (last - first) / parts


def centre(hampm, *settings, growth="", cycles="ratio = 0.1", **more):
    """The crack in the middle, with other keys of its growth and its cycles."""
    text = (INPUT / "fatigue_centre_crack.nml").read_text().replace("   rate_exponent = 3.0\n", f"   rate_exponent = 3.0\n   {growth}\n")
    return run(hampm, text.replace("   ratio = 0.1\n", f"   {cycles}\n"), *settings, **more)


def off(row, asked):
    """The life that is found over the one that is asked, less 1."""
    print(f"cycles {row['cycles'][-1]:.7g}, asked {asked:.7g}, off by {100 * (row['cycles'][-1] / asked - 1):.3f} %")
    return row["cycles"][-1] / asked - 1


def test_paris_life_of_a_crack_in_the_middle(hampm):
    """The integral of da/(C dK**m) from 10 to 30 mm with K of the finite plate: half a percent, of which K has 0.07 % of its cells, times m."""
    row = centre(hampm)
    k = intensity()
    assert row["crack_length"] == pytest.approx(np.arange(10, 31) * 1e-3, rel=1e-9)
    assert abs(off(row, cycles(lambda a: C * (RANGE * k(a)) ** M, 0.01, 0.03))) < 0.005
    assert row["delta_K"] == pytest.approx(0.9 * row["K_I"], rel=1e-12) and row["ratio_of_K"] == pytest.approx(0.1, rel=1e-12)
    assert row["growth_rate"] == pytest.approx(C * row["delta_K"] ** M, rel=1e-12)
    assert row["load_factor"] == pytest.approx(1.0, rel=1e-12) and not row.said


def test_life_converges_with_the_square_of_the_increment(hampm):
    """Cycles for one way with increments of 4, 2 and 1 mm, against the closed integration with K of the run with the shortest ones."""
    rows = [centre(hampm, *COARSE, f"growth.increment={1e-3 * h}", f"method.load_steps={20 // h}", f"run.end_time={20.0 / h}", name=f"h{h}") for h in (4, 2, 1)]
    k = of_run(rows[-1])
    error = [abs(off(row, cycles(lambda a: C * (RANGE * k(a)) ** M, 0.01, 0.03))) for row in rows]
    order = np.log2(np.array(error[:-1]) / error[1:])
    print("observed order", order)
    assert np.all(order > 1.8) and error[-1] < 2e-4


def test_walker_counts_the_mean_load(hampm):
    """dK/(1 - R)**(1 - w) in place of dK: by Walker at R = 0.5 the life is that of Paris with this range."""
    paris, walker = (centre(hampm, *SHORT, growth=keys, cycles=cycle, name=name) for name, keys, cycle in (
        ("paris", "", "ratio = 0.1"), ("walker", "rate = 'walker'  walker_exponent = 0.6", "ratio = 0.5")))
    times = (0.9 / (0.5 / 0.5**0.4)) ** M
    assert walker["cycles"] == pytest.approx(times * paris["cycles"], rel=1e-10)
    assert np.all(walker["ratio_of_K"] == 0.5)


def test_no_growth_below_the_threshold(hampm):
    """Below it the run ends at once; above it nothing changes. In blocks only those above it let the crack grow, while all count."""
    base = centre(hampm, *SHORT, name="base")
    first = base["delta_K"][0]
    assert np.array_equal(centre(hampm, *SHORT, growth=f"threshold = {0.99 * first}", name="above")["cycles"], base["cycles"])
    below = centre(hampm, *SHORT, growth=f"threshold = {1.01 * first}", name="below")
    assert len(below["cycles"]) == 1 and "no tip grows any more" in below.said
    blocks = centre(hampm, *SHORT, growth=f"threshold = {0.99 * first}", cycles="ratio = 0.1  blocks = 300.0, 100.0  factors = 0.3, 1.0  repeat = .true.", name="blocks")
    assert blocks["cycles"] == pytest.approx(4 * base["cycles"], abs=400)


def test_arrest_within_an_increment(hampm):
    """A beam that is split by a given opening of its ends: K falls with its length, and the crack arrests where its range is the threshold."""
    text = """&run plane = 'stress'  end_time = 8.0 /
&grid lower = 0.0, 0.0  cell = 1e-3  cells = 100, 11 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.1, 0.01 /
&constraint lower = 0.0, 10e-3  upper = 0.0, 10e-3  fix = 'y'  displacement = 0.0, 1e-4 /
&constraint lower = 0.03, 0.0  upper = 0.1, 0.0  fix = 'y' /
&constraint lower = 0.1, 0.0  upper = 0.1, 0.01  fix = 'x' /
&crack kind = 'symmetry'  tip = 0.03, 0.0 /
&growth law = 'fatigue'  direction = 'straight'  increment = 2e-3  rate_constant = 1e-29  rate_exponent = 3.0  threshold = THRESHOLD /
&method time = 'static'  load_steps = 8 /
&energy_release estimators = 'domain_integral' /
&output file = 'out.h5' /
"""
    free = run(hampm, text.replace("THRESHOLD", "0.0"), name="free")
    assert np.all(np.diff(free["delta_K"]) < 0)
    row = run(hampm, text.replace("THRESHOLD", str((free["delta_K"][3] + free["delta_K"][4]) / 2)), name="arrest")
    assert "arrest" in row.said and row["cycles"] == pytest.approx(free["cycles"][:4], rel=1e-12)


def test_forman_to_fracture(hampm):
    """da/dN = C dK**m/((1 - R) K_c - dK) up to where the largest K is K_c: the life is an attribute, and the run ends there."""
    k_c, constant = 40e6, 1e-29 * 40e6
    row = centre(hampm, f"growth.rate_constant={constant!r}", growth=f"rate = 'forman'  toughness = {k_c**2 / YOUNG!r}")
    k = intensity()
    a = np.linspace(0.01, 0.03, 200001)
    last = a[np.searchsorted(k(a) * LARGEST, k_c)]
    asked = cycles(lambda a: constant * (RANGE * k(a)) ** M / (0.9 * (k_c - LARGEST * k(a))), 0.01, last)
    print("life", row["life"], "asked", asked, row["life"] / asked - 1)
    assert row["life"] == pytest.approx(asked, rel=0.005)
    assert row["crack_length"][-1] < last < row["crack_length"][-1] + 1e-3
    assert "fracture after" in row.said


def test_forman_to_fracture_along_an_r_curve(hampm):
    """K_c rises with the way from 25 to 38 MPa m^0.5 within 8 mm. The closed integration has K_c of the place, and ends where K has reached that."""
    k_c, way, constant = (25e6, 38e6), 8e-3, 1e-29 * 40e6
    row = centre(hampm, f"growth.rate_constant={constant!r}", "refine.max_level=3",
                 growth=f"rate = 'forman'  toughness = {k_c[0]**2 / YOUNG!r}  extensions = 0.0, {way}  extension_factors = 1.0, {(k_c[1] / k_c[0])**2!r}")
    k = of_run(row)  # what is left is the error of the cycles and of where the run ends

    def resistance(a):
        return np.sqrt(np.interp(a - 0.01, [0, way], np.square(k_c)))

    a = np.linspace(0.01, 0.03, 200001)
    last = a[np.argmax(k(a) * LARGEST > resistance(a))]
    asked = cycles(lambda a: constant * (RANGE * k(a)) ** M / (0.9 * (resistance(a) - LARGEST * k(a))), 0.01, last)
    print("life", row["life"], "asked", asked, row["life"] / asked - 1, "last", last, row["crack_length"][-1])
    assert row["life"] == pytest.approx(asked, rel=0.005)
    assert row["crack_length"][-1] < last < row["crack_length"][-1] + 1e-3
    assert row["toughness"] == pytest.approx(resistance(row["crack_length"]) ** 2 / YOUNG, rel=1e-12)


def test_toughness_by_body_direction_and_mix_of_modes(hampm):
    """A slanted crack runs into a body of a hundredth of the toughness, which falls from along x to along y: the law of Forman has K_c of the product of all, and the run
    ends at the seam."""
    text = (INPUT / "fatigue_eccentric_crack.nml").read_text()
    for group in ("&body", "&load\n   kind = 'traction'\n   lower = -40.0e-3, 100.0e-3", "&load\n   kind = 'traction'\n   lower = -40.0e-3, -100.0e-3"):
        start = text.index(group)
        whole = text[start:text.index("/\n", start) + 2]
        left = whole.replace("60.0e-3,", "14.5e-3,").replace("&body", "&body toughness = 300.0e3")
        text = text[:start] + left + whole.replace("-40.0e-3,", "14.5e-3,").replace("&body", "&body toughness = 3.0e3") + text[text.index("/\n", start) + 2:]
    text = text.replace("0.3e-3, 10.0e-3, 0.3e-3", "-6.0e-3, 10.0e-3, 6.0e-3").replace("rate_exponent = 3.0", """rate_exponent = 3.0  rate = 'forman'  toughness = 1.0  angles = 0.0, 90.0  angle_factors = 2.0, 1.0
   mixed_mode = 'benzeggagh_kenane'  toughness_shear = 3.0  mixed_mode_exponent = 1.5""")
    row = run(hampm, text, "refine.max_level=1", "growth.increment=2e-3", "growth.rate_constant=1e-22", "output.snapshot_interval=0")
    share = row["K_II"]**2 / (row["K_I"]**2 + row["K_II"]**2)
    assert np.all(share > 0.02)
    asked = np.where(row["tip_x"] < 14.5e-3 - 1e-9, 300e3, 3e3) * (2 - np.degrees(np.arctan(0.6)) / 90) * (1 + 2 * share**1.5)
    print(row["tip_x"], row["tip_x_tip2"], share, row["toughness"] / asked - 1, row["life"], row["cycles"])
    assert row["toughness"] == pytest.approx(asked, rel=2e-3)                       # shares of J are those of K to that
    k_c = np.sqrt(YOUNG * row["toughness"])
    largest = np.sqrt(YOUNG * row["G"])
    rate = 1e-22 * row["delta_K"]**3 / row["delta_K"] * (largest / k_c) / (1 - largest / k_c)
    assert row["growth_rate"][:-1] == pytest.approx(rate[:-1], rel=1e-9) and largest[-1] > k_c[-1]
    assert "fracture after" in row.said and row["tip_x"][-1] == pytest.approx(14.5e-3, abs=1e-9) and row["life"] == row["cycles"][-1]


def wheeler(k, blocks, exponent, stress, first, last, part=2e-6):
    """Cycles of a way with Wheeler's retardation, by short straight steps: an integration of its own."""
    a, count, zone, left = first, 0.0, first, [list(block) for block in blocks]
    while a < last:
        number, factor, ratio = left[0]
        largest = factor * LARGEST * k(a)
        radius = (largest / stress) ** 2 / np.pi
        zone = max(zone, a + radius)
        rate = C * (largest * (1 - ratio)) ** M * min(1.0, radius / (zone - a)) ** exponent
        step = min(part / rate, number, (last - a) / rate)
        a, count, left[0][0] = a + rate * step, count + step, number - step
        if left[0][0] <= 0:
            left.pop(0)
    return count


def test_an_overload_slows_the_crack_down(hampm):
    """input/fatigue_overload.nml: 1000 cycles of 1.6 times the load after 40000, with the retardation of Wheeler; K from the run."""
    row = run(hampm, INPUT / "fatigue_overload.nml")
    k = of_run(row)
    blocks = [(40e3, 1.0, 0.1), (1e3, 1.6, 0.1), (np.inf, 1.0, 0.1)]
    asked = wheeler(k, blocks, 1.3, 350e6, 0.01, row["crack_length"][-1])
    without = wheeler(k, blocks, 0.0, 350e6, 0.01, row["crack_length"][-1])
    print("without retardation", without)
    assert abs(off(row, asked)) < 0.003
    assert row["cycles"][-1] > 1.1 * without
    slow = row["growth_rate"] / (C * row["delta_K"] ** M)
    assert np.min(slow) < 0.5 and slow[0] == 1 and slow[-1] == 1


def test_blocks_that_repeat(hampm):
    """A spectrum of short blocks has the mean of the rates of its blocks, and all cycles count."""
    row = centre(hampm, *COARSE, "method.load_steps=8", "run.end_time=8", cycles="ratio = 0.1  blocks = 50.0, 3.0, 20.0  factors = 1.0, 1.4, 0.6  repeat = .true.")
    k = of_run(row)
    mean = (50 + 3 * 1.4**M + 20 * 0.6**M) / 73
    assert abs(off(row, cycles(lambda a: mean * C * (RANGE * k(a)) ** M, 0.01, 0.018))) < 3e-4


STOPS = """\
&run plane = 'stress'  end_time = 6.0 /
&grid lower = -2e-3, -42e-3  cell = 1e-3  cells = 44, 84 /
&material name = 'steel'  young = 200e9  poisson = 0.3  density = 7850 /
&body material = 'steel'  lower = 0.0, -40e-3  upper = 40e-3, 40e-3 /
&load kind = 'traction'  lower = 0.0, 40e-3  upper = 40e-3, 40e-3  force = 0.0, 100e3 /
&load kind = 'traction'  lower = 0.0, -40e-3  upper = 40e-3, -40e-3  force = 0.0, -100e3 /
&crack kind = 'path'  name = 'a'  points = -1e-3, 10.3e-3, 6.1e-3, 10.3e-3 /
&crack kind = 'path'  name = 'b'  points = 41e-3, -10.3e-3, 33.9e-3, -10.3e-3 /
&growth crack = 'a'  law = 'fatigue'  direction = 'straight'  increment = 2e-3  rate_constant = 1e-29  rate_exponent = 3.0  max_length = 9e-3 /
&growth crack = 'b'  law = 'fatigue'  direction = 'straight'  increment = 2e-3  rate_constant = 1e-29  rate_exponent = 3.0  threshold = 5e5 /
&cycles blocks = 5e10, 1e12  factors = 0.5, 2.0 /
&method time = 'static'  load_steps = 6 /
&energy_release estimators = 'domain_integral' /
"""


def test_a_tip_that_has_stopped_does_not_end_the_cycles_of_another(hampm):
    """In the first block crack a grows until it has its largest length, and b is below its threshold: b grows in the second."""
    row = run(hampm, STOPS)
    cycles, b = row["cycles"], -row["tip_x_tip2"]
    assert 0 < cycles[1] < 5e10 < cycles[2] and len(cycles) == 7
    assert row["tip_x"][-1] == pytest.approx(8.1e-3) and np.all(np.diff(b[1:]) > 1.9e-3)
    rates = 1e-29 * (2 * row["K_I_tip2"])**3
    asked = np.cumsum(np.diff(b) * (1 / rates[1:] + 1 / rates[:-1]) / 2)[1:]
    found = cycles[2:] - 5e10
    print(found / asked)
    assert found == pytest.approx(asked, rel=0.06)  # trapezoids of increments of a quarter of the crack


def test_two_tips_at_rates_of_their_own(hampm):
    """input/fatigue_eccentric_crack.nml: the tip nearer to an edge is faster. Places and cycles of both are those of the reference."""
    row = run(hampm, INPUT / "fatigue_eccentric_crack.nml")
    count, left, right, k_left, k_right = reference("g2_fatigue_eccentric_crack.csv")
    x = row["tip_x_tip2"] * 1e3
    assert np.diff(x) == pytest.approx(-1, rel=1e-9)  # it goes by the increment
    n, other = len(x), np.interp(-x, -left, right)
    print("cycles", row["cycles"][1:] / count[1:n] - 1, "other tip [mm]", row["tip_x"] * 1e3 - other)
    assert row["cycles"][-1] == pytest.approx(count[n - 1], rel=0.005)
    assert row["tip_x"] * 1e3 == pytest.approx(other, abs=0.03)
    assert row["K_I_tip2"] == pytest.approx(1e6 * k_left[:n], rel=0.003) and row["K_I"] == pytest.approx(1e6 * np.interp(-x, -left, k_right), rel=0.003)


def test_held_load_is_the_mean_load_of_a_cycle(hampm):
    """Half of the load held and half of it in cycles from 0 to 1 is the whole of it at a load ratio of 0.5."""
    text = (INPUT / "fatigue_centre_crack.nml").read_text().replace("   rate_exponent = 3.0\n", "   rate_exponent = 3.0\n   rate = 'walker'\n   walker_exponent = 0.5\n")
    load = text[text.index("&load"):text.index("/\n", text.index("&load")) + 2]
    half = load.replace("50.0e3", "25.0e3")
    whole = run(hampm, text.replace("ratio = 0.1", "ratio = 0.5"), *SHORT, name="whole")
    held = run(hampm, text.replace("ratio = 0.1", "ratio = 0.0").replace(load, half + half.replace("kind =", "held = .true.\n   kind =")), *SHORT, name="held")
    for name in ("cycles", "delta_K", "ratio_of_K", "growth_rate"):
        assert held[name] == pytest.approx(whole[name], rel=1e-7), name


def plate(direction, loads, cycles, points="0.0, 0.0, 8.0e-3, 2.0e-3", growth="", level=1, law="fatigue"):
    """A slanted edge crack in a plate under tractions of so many MPa, each held or of the cycles."""
    tractions = "".join(f"&load kind = 'traction'  lower = 0.0, {y}  upper = 0.04, {y}  force = 0.0, {side * 400.0 * load}  held = .{held}. /\n"
                        for load, held in loads for side, y in ((1, 0.04), (-1, -0.04)))
    return f"""&run plane = 'stress'  thickness = 0.01  end_time = 4.0 /
&grid lower = -2e-3, -0.042  cell = 2e-3  cells = 22, 42 /
&material name = 's'  young = 200e9  poisson = 0.3  density = 7850 /
&body material = 's'  lower = 0.0, -0.04  upper = 0.04, 0.04 /
{tractions}&constraint lower = 0.04, 0.0  upper = 0.04, 0.0  fix = 'xy' /
&constraint lower = 0.02, 0.0  upper = 0.02, 0.0  fix = 'y' /
&crack kind = 'path'  points = {points} /
&growth law = '{law}'  direction = '{direction}'  increment = 2.0e-3  {growth or "rate_constant = 1e-29  rate_exponent = 3.0"} /
&cycles {cycles} /
&refine indicator = 'tip'  max_level = {level}  rings = 6 /
&method time = 'static'  load_steps = 4 /
&energy_release estimators = 'domain_integral' /
&output file = 'out.h5' /
"""


@pytest.mark.parametrize(("direction", "loads", "cycles", "others", "other_cycles"), [
    ("local_symmetry", ((100, "true"), (-60, "false")), "ratio = 0.0", ((40, "true"), (60, "false")), "ratio = 0.0"),
    ("hoop_stress", ((-50, "false"),), "ratio = -2.0", ((100, "false"),), "ratio = -0.5"),
    ("straight", ((90, "true"), (-30, "false")), "ratio = 0.5  blocks = 9e3, 1e3  factors = 1.0, 2.0  repeat = .true.",
     ((30, "true"), (45, "false")), f"blocks = 9e3, 1e3  factors = 1.0, {2 / 3!r}  ratios = {2 / 3!r}, 0.0  repeat = .true."),
], ids=["held", "falls", "blocks"])
def test_the_largest_load_of_a_cycle_is_at_either_of_its_ends(hampm, direction, loads, cycles, others, other_cycles):
    """The same stresses in time as loads that rise from the least one and as loads that fall from the largest one: the range of K, R, rates, cycles and paths are the same."""
    falls, rises = (run(hampm, plate(direction, *scene), name=name) for name, scene in (("falls", (loads, cycles)), ("rises", (others, other_cycles))))
    assert np.all(rises["growth_rate"] > 0) and len(rises["cycles"]) == 5
    for column in ("cycles", "delta_K", "growth_rate", "crack_length", "tip_x"):
        assert falls[column] == pytest.approx(rises[column], rel=1e-6), column
    assert falls["ratio_of_K"] == pytest.approx(rises["ratio_of_K"], abs=1e-6)


def test_held_tension_and_cycles_of_compression_to_fracture(hampm):
    """K_c is held against K at the larger end of a cycle: the life is that of the same stresses by loads that rise."""
    keys = "rate_constant = 1e-29  rate_exponent = 3.0  toughness = 4.0e3"
    falls, rises = (run(hampm, plate("straight", loads, "ratio = 0.0", growth=keys), name=name) for name, loads in (
        ("falls", ((100, "true"), (-60, "false"))), ("rises", ((40, "true"), (60, "false")))))
    assert falls["life"] == pytest.approx(rises["life"], rel=1e-9) and falls["life"] > 0


def test_a_least_load_below_zero_counts_as_zero(hampm):
    """Faces that would pass through each other, as no contact is asked for: cycles of R = -1 are those of R = 0."""
    reversed_, zero = (centre(hampm, *SHORT, cycles=f"ratio = {ratio}", name=f"r{ratio}") for ratio in (-1.0, 0.0))
    for column in ("cycles", "delta_K", "ratio_of_K", "growth_rate"):
        assert reversed_[column] == pytest.approx(zero[column], rel=1e-9), column
    assert zero["cycles"][-1] > 0


def test_faces_in_contact_carry_no_more_in_compression(hampm):
    """At R = -1 a crack whose faces press on each other has the range of R = 0, up to what faces in contact overlap."""
    text = (INPUT / "fatigue_eccentric_crack.nml").read_text()
    settings = ("refine.max_level=1", "growth.increment=2e-3", "method.load_steps=1", "run.end_time=1", "output.snapshot_interval=0")
    path = text.index("points = ")
    closed = text[:path] + "contact = 'frictionless'\n   " + text[path:]
    rows = [run(hampm, scene + f"&cycles ratio = {ratio} /\n", *settings, name=name) for name, scene, ratio in (("open", text, 0.0), ("closed", closed, -1.0))]
    print(rows[1]["delta_K"] / rows[0]["delta_K"])
    assert rows[1]["delta_K"] == pytest.approx(rows[0]["delta_K"], rel=1e-3)


@pytest.mark.verify
def test_a_path_past_a_hole(hampm):
    """input/fatigue_hole.nml: the crack turns to the hole by 20 degrees and more, and back; it has no K_II anywhere, and breaks where K_I is that of the toughness."""
    row = run(hampm, INPUT / "fatigue_hole.nml", "output.snapshot_interval=0")
    print(row["tip_angle"], row["K_I"][-1], row["cycles"][-1])
    assert 20 < np.max(row["tip_angle"]) < 25 and abs(row["tip_angle"][-1]) < 1
    assert np.all(np.abs(row["K_II"][1:]) < 1.1e-3 * row["K_I"][1:])
    assert "fracture after" in row.said and row["K_I"][-1] < np.sqrt(40e3 * YOUNG) < 1.2 * row["K_I"][-1]


@pytest.mark.verify
def test_path_and_cycles_past_a_hole_converge(hampm):
    """With increments of half the length, and with cells of half the size. Increments are straight, which makes the path of first order: it is off by less than a quarter of
    the increment where it bends. Cycles hardly hang on that."""
    row = run(hampm, INPUT / "fatigue_hole.nml", "output.snapshot_interval=0")
    for name, settings in (("increments", ("growth.increment=0.625e-3", "method.load_steps=60", "run.end_time=60")), ("cells", ("refine.max_level=3",))):
        other = run(hampm, INPUT / "fatigue_hole.nml", *settings, "output.snapshot_interval=0", name=name)
        inside = (row["tip_x"] > 0.009) & (row["tip_x"] < other["tip_x"][-1])
        apart = np.interp(row["tip_x"], other["tip_x"], other["tip_y"])[inside] - row["tip_y"][inside]
        count = np.interp(row["crack_length"], other["crack_length"], other["cycles"])[inside] / row["cycles"][inside] - 1
        print(name, "apart [mm]", np.max(np.abs(apart)) * 1e3, "cycles", np.max(np.abs(count)))
        assert np.max(np.abs(apart)) < 1.25e-3 / 4 and np.max(np.abs(count)) < 0.02


@pytest.mark.parametrize(("old", "new", "said"), [
    ("   rate_constant = 1.0e-29   ! m/cycle where the range of K is 1 Pa sqrt(m)\n", "", "requires increment > 0 and rate_constant > 0 and rate_exponent > 0"),
    ("   increment = 1.0e-3\n", "", "requires increment > 0"),
    ("rate_exponent = 3.0", "rate_exponent = 3.0  rate = 'walker'", "requires walker_exponent"),
    ("rate_exponent = 3.0", "rate_exponent = 3.0  rate = 'forman'", "requires toughness > 0"),
    ("rate_exponent = 3.0", "rate_exponent = 3.0  walker_exponent = 0.5", "requires rate = 'walker'"),
    ("rate_exponent = 3.0", "rate_exponent = 3.0  wheeler_exponent = 1.0", "requires wheeler_stress > 0"),
    ("rate_exponent = 3.0", "rate_exponent = 3.0  tips = 'largest'", "each tip has a rate of its own"),
    ("rate_exponent = 3.0", "rate_exponent = 3.0  start = 1.0", "a static model has no time"),
    ("law = 'fatigue'", "law = 'quasi_static'  toughness = 1.0", "&cycles requires &growth law = 'fatigue'"),
    ("ratio = 0.1", "ratio = 1.0", "must be in (-inf, 1)"),
    ("ratio = 0.1", "factors = 1.0, 2.0", "requires blocks"),
    ("ratio = 0.1", "blocks = 10.0, 20.0  factors = 1.0", "factors = 1.0: must have one value for each of the 2 blocks"),
    ("ratio = 0.1", "blocks = 10.0, 20.0  ratios = 0.1, 0.2, 0.3", "must have one value for each of the 2 blocks"),
    ("ratio = 0.1", "blocks = 10.0, 0.0", "must be in (0, inf)"),
    ("force = 0.0, 50.0e3", "force = 0.0, 50.0e3  history = 'ramp'  rise_time = 1.0", "&cycles tells how loads change"),
    ("force = 0.0, 50.0e3", "force = 0.0, 50.0e3  held = .true.", "something that growth scales"),
    ("&cycles", "&control quantity = 'load' /\n&cycles", "&cycles tells how loads change")])
def test_bad_input_is_named(hampm, old, new, said):
    text = (INPUT / "fatigue_centre_crack.nml").read_text()
    assert old in text
    assert said in " ".join(run(hampm, text.replace(old, new), code=2).split())


def test_a_run_that_is_resumed_or_has_more_threads_has_the_same_bytes(hampm):
    """Blocks, zones of overloads and what tips are owed go on."""
    text = (INPUT / "fatigue_eccentric_crack.nml").read_text().replace("rate_exponent = 3.0", "rate_exponent = 3.0  wheeler_exponent = 1.3  wheeler_stress = 350e6") \
        + "&cycles ratio = 0.1  blocks = 300.0, 2.0, 50.0  factors = 1.0, 1.4, 0.6  repeat = .true. /\n"
    settings = ("refine.max_level=1", "growth.increment=2e-3", "method.load_steps=4", "run.end_time=4")
    whole = run(hampm, text, *settings, name="whole")
    run(hampm, text, *settings, words=("--steps", "2"), code=5, name="part")
    assert hampm("--resume", hampm.folder / "part.h5.checkpoint", "--quiet").returncode == 0
    assert not differing(whole.path, hampm.folder / "part.h5")
    threads = run(hampm, text, *settings, words=("--threads", "2"), name="threads")
    assert not differing(whole.path, threads.path)


def test_friction_of_a_closed_crack_locks_what_has_slid(hampm):
    """A crack that is pressed shut slides by t - f s, with shear t and pressure s in its line. As the load falls to the part R of it faces stick, until t R + f s R is less than
    that: K_II falls to (t + f s) R/(t - f s) of its largest value, and not to R."""
    text = (INPUT / "wing_cracks.nml").read_text().replace("   toughness = 10.0\n", "   law = 'fatigue'\n   rate_constant = 1e-20\n   rate_exponent = 3.0\n")
    row = run(hampm, text + "&cycles ratio = 0.5 /\n", "method.load_steps=1", "output.snapshot_interval=0", "grid.cell=2e-3", "grid.cells=45,50", "growth.increment=4.4e-3")
    angle, f = np.radians(36.65), 0.3
    t, s = np.sin(angle) * np.cos(angle), np.sin(angle) ** 2
    asked = 0.5 * (t + f * s) / (t - f * s)
    print(row["ratio_of_K"][0], asked)
    assert row["K_I"][0] == 0 and row["ratio_of_K"][0] == pytest.approx(asked, rel=0.005)
    assert row["delta_K"][0] == pytest.approx((1 - asked) * abs(row["K_II"][0]), rel=0.01)


@pytest.mark.parametrize(("constant", "told"), [(1e-11, "less than one load cycle"), (1e-29, ""), (1e-26, "in each of which a tip went on by more than it opens"), (1e-38, "more than any test")])
def test_growth_that_is_none_of_cycles_is_told(hampm, constant, told):
    """C of a table for MPa m^0.5, not converted, is 1e18 times too large: an increment then takes 1e-14 of a cycle, at a K that is named. For mm it is 1000 times too large: the tip goes on
    by more than K**2/(4 E yield stress) in a cycle. With 1e9 times too little an increment takes 1e14 cycles."""
    row = centre(hampm, *SHORT, f"growth.rate_constant={constant!r}", "growth.rate_exponent=3")
    assert ("an increment of growth has taken " in row.said) == (told != "") and told in row.said
    assert row.said.count("Pa m^0.5: the law of growth is not for such K") == (told != "")
