"""Pressure under an elastic layer that a line force presses on a half plane of the same material, without friction: the layer lifts off beyond a half-width b that does not
depend on the force (receding contact; Keer, Dundurs & Tsai, J. Appl. Mech. 39 (1972) 1115-1120, have the problem).

    .venv/bin/python tools/references/receding_contact.py > tests/reference/contact/receding.csv

Lengths over the thickness of the layer, E' = 1. An Airy function (A + B y) cosh ky + (C + D y) sinh ky gives the displacement of the lower face of the layer by tractions on
both faces, for each wave number k; that of the half plane is 2/k. Slopes of both are the same within b. The pressure is sqrt(1 - (x/b)**2) times a polynomial of even
powers, by collocation in the sense of least squares; b is where that has the least residual."""

import numpy as np

STEP, LAST, TERMS, PLACES = 2.5e-3, 40.0, 12, 400


def displacements(k):
    """Of the lower face, by unit pressure below and by unit traction from above."""
    c, s = np.cosh(k), np.sinh(k)
    below, slope_below = np.array([1, 0, 0, 0]), np.array([0, 1, k, 0])
    above, slope_above = np.array([c, c, s, s]), np.array([k * s, c + k * s, k * c, s + k * c])
    matrix = np.array([-k * k * below, k * slope_below, -k * k * above, k * slope_above])
    size = np.max(np.abs(matrix), axis=1)
    found = []
    for right in ([-1, 0, 0, 0], [0, 0, -1, 0]):
        _, b, c_, _ = np.linalg.solve(matrix / size[:, None], np.array(right) / size)
        found.append((3 * b * k * k + c_ * k**3) / k**2)
    return found


def main():
    k = np.arange(STEP, LAST, STEP)
    of_layer = np.array([displacements(one) if one < 25 else (2 / one, 0.0) for one in k])
    by_pressure, by_load = k * (of_layer[:, 0] + 2 / k), k * of_layer[:, 1]
    angle = (np.arange(PLACES) + 0.5) * np.pi / (2 * PLACES)
    shapes = np.array([np.cos(2 * j * angle) * np.sin(angle) for j in range(TERMS)])

    def solve(b):
        x, weight = b * np.cos(angle), np.pi / (2 * PLACES) * b * np.sin(angle)
        transform = 2 * shapes * weight @ np.cos(np.outer(x, k))
        sines = np.sin(np.outer(k, b * np.sin((np.arange(3 * TERMS) + 0.5) * np.pi / (6 * TERMS)))) * STEP
        matrix, right = ((transform * by_pressure) @ sines).T, -by_load @ sines
        force = 2 * shapes @ weight
        first, others = force / (force @ force), np.linalg.svd(force[None])[2][1:].T
        part = np.linalg.lstsq(matrix @ others, right - matrix @ first, rcond=None)[0]
        found = first + others @ part
        return np.linalg.norm(matrix @ found - right), found

    widths = np.arange(1.29, 1.3251, 0.001)
    residuals = [solve(b)[0] for b in widths]
    b = widths[np.argmin(residuals)]
    _, found = solve(b)
    print(f"# tools/references/receding_contact.py: half-width of the contact {b:.3f}\nx_over_h,p_h_over_force")
    for x in np.arange(0, 1.26, 0.0625):
        at = np.arccos(x / b)
        print(f"{x:.4f},{sum(c * np.cos(2 * j * at) * np.sin(at) for j, c in enumerate(found)):.5f}")


if __name__ == "__main__":
    main()
