"""Wing cracks by dislocations: a crack that slides with friction, and its wings, in an infinite body and in the plate of input/wing_cracks.nml.

    python tools/references/wing_cracks.py tests/reference/growth

writes p5_wing_cracks.csv and p6_straight_wings.csv there. Nothing here is shared with the program.

Each crack is a row of elements over each of which the faces are parted by the same amount, that is, of a dislocation at both of its ends; elements
become shorter by the third power towards tips and kinks. Stresses of a dislocation b at z0 in a plane (Muskhelishvili; Hills et al., Solution of Crack
Problems, 1996), with g = G b/(i pi (kappa + 1)):

    s_xx + s_yy = 4 Re g/(z - z0),    s_yy - s_xx + 2 i s_xy = 2 (conj(g)/(z - z0) - g conj(z - z0)/(z - z0)**2)

Wings and edges are free of tractions; edges are elements, too, on which the rigid motions are held by three multipliers. The faces of the crack slide
under the shear stress friction times pressure, and do not open (Dn = 0) unless they would be pulled. K is that of the last element of a wing over that of a
straight crack of as many elements, and the error of elements falls with their number: the values are 2 K(2 n) - K(n). For a kinked crack in tension
(a4_kinked_infinite.csv) that is within 5e-4 with n = 40.
"""

import sys
from pathlib import Path

import numpy as np

YOUNG, POISSON, TOUGHNESS = 70e9, 0.2, 10.0
HALF, ANGLE = 8e-3, np.radians(36.65)  # of the crack: half-length, and angle to the compression along y
AXIS = np.exp(1j * (np.pi / 2 - ANGLE))
K_C = np.sqrt(YOUNG / (1 - POISSON**2) * TOUGHNESS)
SHEAR, KAPPA = YOUNG / 2 / (1 + POISSON), 3 - 4 * POISSON
PLATE = 45e-3, 50e-3  # half-width and half-height


def row_of(begin, end, number, power=3.0):
    """Ends of 2 `number` elements, crowded at both ends."""
    half = 0.5 * (np.arange(number + 1) / number)**power
    return begin + (end - begin) * np.concatenate([half, 1 - half[-2::-1]])


def influence(begin, end, centre, tangent):
    """Normal and shear stress on each element by one unit of sliding and of opening of each."""
    normal, shear = [], []
    along = (end - begin) / abs(end - begin)
    for jump in (along, 1j * along):
        g = SHEAR * jump / (1j * np.pi * (KAPPA + 1))
        total, deviator = 0, 0
        for sign, place in ((1, begin), (-1, end)):
            z = centre[:, None] - place[None]
            total = total + sign * 4 * (g / z).real
            deviator = deviator + sign * 2 * (np.conj(g) / z - g * np.conj(z) / z**2)
        turned = deviator * tangent[:, None]**2
        normal.append((total + turned.real) / 2)
        shear.append(turned.imag / 2)
    return np.hstack(normal), np.hstack(shear)


def discontinuities(rows, stress, friction):
    """Sliding and opening of each element under a uniform stress (xx, yy, xy): rows are (ends, kind), of 'closed', 'open' or 'edge'."""
    begin, end = (np.concatenate([points[part] for points, _ in rows]) for part in (slice(None, -1), slice(1, None)))
    kind = np.concatenate([[kind] * (len(points) - 1) for points, kind in rows])
    centre, tangent, n = (begin + end) / 2, (end - begin) / abs(end - begin), len(begin)
    normal, shear = influence(begin, end, centre, tangent)
    turned = (stress[1] - stress[0] + 2j * stress[2]) * tangent**2
    inside = kind != "edge"  # the uniform stress is in balance with the loads on the edges
    normal_0, shear_0 = inside * (stress[0] + stress[1] + turned.real) / 2, inside * turned.imag / 2
    edge, closed = np.flatnonzero(~inside), kind == "closed"
    hold = np.zeros((2 * n, 3 if edge.size else 0))
    for k, motion in enumerate((tangent.conj(), 1j * tangent.conj(), 1j * centre * tangent.conj() / abs(centre).max())[:hold.shape[1]]):
        hold[edge, k], hold[n + edge, k] = motion.real[edge], motion.imag[edge]
    while True:
        matrix, right = np.vstack([shear, normal]), -np.concatenate([shear_0, normal_0])
        i = np.flatnonzero(closed)
        factor = -friction * np.sign(shear_0[i])[:, None]
        matrix[i] = shear[i] - factor * normal[i]
        right[i] = -(shear_0[i] - factor[:, 0] * normal_0[i])
        matrix[n + i], right[n + i] = 0, 0
        matrix[n + i, n + i] = SHEAR
        size = abs(matrix).max()
        bordered = np.block([[matrix, size * hold], [size * hold.T, np.zeros((hold.shape[1],) * 2)]])
        found = np.linalg.solve(bordered, np.concatenate([right, np.zeros(hold.shape[1])]))[:2 * n]
        pulled = closed & (normal @ found + normal_0 > 1e-9 * abs(normal_0).max())
        if not pulled.any():
            return found[:n], found[n:], begin, end
        closed &= ~pulled


def intensity_once(wing, n, friction, plate):
    """K_I and K_II of a wing, a list of points from the tip of the crack on, under a compression of 1 Pa along y."""
    other = [-z for z in wing]
    rows = [(row_of(-HALF * AXIS, HALF * AXIS, n), "closed")]  # alone it is its own wing
    rows += [(row_of(a, b, n), "open") for points in (other, wing) for a, b in zip(points[:-1], points[1:])]
    last = sum(len(points) - 1 for points, _ in rows) - 1
    if plate:
        corners = [complex(x * plate[0], y * plate[1]) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))]
        rows += [(row_of(a, b, 60, 1.5), "edge") for a, b in zip(corners[:-1], corners[1:])]
    slides, opens, begin, end = discontinuities(rows, (0.0, -1.0, 0.0), friction)
    straight, _, a, b = discontinuities([(row_of(-1, 1, n), "open")], (0.0, 0.0, 1.0), 0.0)
    unit = straight[-1] / np.sqrt(abs(b[-1] - a[-1]) * np.pi)
    size = np.sqrt(abs(end[last] - begin[last]))
    return np.array([opens[last], slides[last]]) / size / unit


def intensity(wing, friction, plate=None, n=20):
    return 2 * intensity_once(wing, 2 * n, friction, plate) - intensity_once(wing, n, friction, plate)


def path(friction, plate, increment=2.2e-3, steps=7):
    """Places, directions and K of wings that grow by local symmetry: each increment is turned until K_II is 1e-4 of K_I. First K of the crack without wings."""
    wing, direction = [HALF * AXIS], np.pi / 2 - ANGLE + np.radians(70)
    yield wing[0], np.angle(AXIS), intensity(wing, friction, plate)
    for _ in range(steps):
        def off(angle):
            return intensity([*wing, wing[-1] + increment * np.exp(1j * angle)], friction, plate, n=16)
        angles = [direction, direction + 0.02]
        k = [off(angle) for angle in angles]
        while abs(k[-1][1]) > 1e-4 * abs(k[-1][0]):
            angles.append(angles[-1] - k[-1][1] * (angles[-1] - angles[-2]) / (k[-1][1] - k[-2][1]))
            k.append(off(angles[-1]))
        direction = angles[-1]
        wing.append(wing[-1] + increment * np.exp(1j * direction))
        yield wing[-1], direction, k[-1]


def slides_by(friction):
    """Shear stress that drives the sliding over the compression."""
    return np.sin(ANGLE) * np.cos(ANGLE) - friction * np.sin(ANGLE)**2


def horii(length, direction, friction, closing=0.5):
    """K_I over that of 1 Pa of straight wings, Horii & Nemat-Nasser (1986); `closing` 0.5 is for short wings, 1 for long ones."""
    opens = 2 * HALF * slides_by(friction) * np.sin(direction - np.angle(AXIS)) / np.sqrt(np.pi * (length + 0.27 * HALF))
    return opens - np.cos(direction)**2 * np.sqrt(np.pi * length * closing)


def ashby(length, friction):
    """K_I over that of 1 Pa, Ashby & Hallam (1986)."""
    part = 1 + length / HALF
    return 2 * slides_by(friction) * np.sqrt(np.pi * HALF) / part**1.5 * (0.23 * (part - 1) + 1 / np.sqrt(3 * part))


def main(folder):
    with open(folder / "p5_wing_cracks.csv", "w") as file:
        file.write(f"""\
# Wings of a closed crack of 2c = 16 mm at 36.65 degrees to a compression of 1 MPa along y, E = 70 GPa, nu = 0.2, plane strain, that grow by local symmetry in increments of 2.2 mm.
# Plate of 90 by 100 mm (input/wing_cracks.nml), and infinite body. Dislocations (tools/references/wing_cracks.py); they solve the kinked cracks of a4_kinked_infinite.csv to 5e-4.
# Loads at which wings grow are K_c/K_I MPa, of the crack without wings K_c/|K_II| by its G, with K_c = {K_C:.1f} Pa*sqrt(m) for the toughness of 10 J/m2.
body,friction,growth[mm],x[mm],y[mm],direction[deg],K_I[Pa*sqrt(m)],K_II[Pa*sqrt(m)]
""")
        for body, plate in (("plate", PLATE), ("infinite", None)):
            for friction in (0.3, 0.0):
                for k, (place, direction, found) in enumerate(path(friction, plate)):
                    print(body, friction, k, flush=True)
                    file.write(f"{body},{friction},{2.2*k:.1f},{1e3*place.real:.5f},{1e3*place.imag:.5f},{np.degrees(direction):.3f},"
                               f"{1e6*found[0]:.1f},{1e6*found[1]:.1f}\n")
    with open(folder / "p6_straight_wings.csv", "w") as file:
        file.write("""\
# What formulas of wing cracks are worth: straight wings of length l in an infinite body, at 70.5 degrees from a crack of half-length c at 36.65 degrees to the compression, or parallel to it.
# K_I over compression times sqrt(pi c) by dislocations (tools/references/wing_cracks.py), and that of each formula over it. Horii & Nemat-Nasser (1986) with l* = 0.27 c, the compression
# across a wing with sqrt(pi l/2), as a wing alone, or sqrt(pi l), as two wings in a line; Ashby & Hallam (1986), whose wings open as most of all at l = 0. A minus: the wing is closed by one of both.
wing,friction,l/c,K_I/(sigma*sqrt(pi*c)),Horii short,Horii long,Ashby
""")
        for wing, direction in (("70.5 degrees", np.angle(AXIS) + np.radians(70.5)), ("axial", np.pi / 2)):
            for friction in (0.3, 0.0):
                for part in (0.1, 0.3, 0.5, 1.0, 2.0, 4.0):
                    length = part * HALF
                    k = intensity([HALF * AXIS, HALF * AXIS + length * np.exp(1j * direction)], friction, n=40)[0]
                    ratios = [horii(length, direction, friction) / k, horii(length, direction, friction, 1.0) / k, ashby(length, friction) / k]
                    print(wing, friction, part, flush=True)
                    file.write(f"{wing},{friction},{part},{k/np.sqrt(np.pi*HALF):.5f}," + ",".join(f"{r:.3f}" for r in ratios) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
