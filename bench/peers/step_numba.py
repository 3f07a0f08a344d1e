"""A plain step of the material point method in Python with numba, for one thread, as one writes it: update stress first, lumped masses,
updated frame, bilinear square cells, one linear elastic material. Particles may stand in any order."""

from numba import njit


@njit(cache=True)
def steps(count, x, v, h, mass, volume, nodal_mass, p, f, nx, cell, lam, mu, dt):
    """Take some steps: x, v (n, 2), h = gradient of the displacement as 11, 12, 21, 22 (n, 4); nodal sums by node, row after row."""
    inverse = 1/cell
    for _ in range(count):
        nodal_mass[:] = 0
        p[:] = 0
        f[:] = 0
        for i in range(len(mass)):
            column, row = int(x[i, 0]*inverse), int(x[i, 1]*inverse)
            xi, eta = x[i, 0]*inverse - column, x[i, 1]*inverse - row
            k = row*(nx + 1) + column
            map_to(k, mass[i]*(1 - xi)*(1 - eta), v[i, 0], v[i, 1], nodal_mass, p)
            map_to(k + 1, mass[i]*xi*(1 - eta), v[i, 0], v[i, 1], nodal_mass, p)
            map_to(k + nx + 1, mass[i]*(1 - xi)*eta, v[i, 0], v[i, 1], nodal_mass, p)
            map_to(k + nx + 2, mass[i]*xi*eta, v[i, 0], v[i, 1], nodal_mass, p)
        divide(p, nodal_mass)
        for i in range(len(mass)):
            column, row = int(x[i, 0]*inverse), int(x[i, 1]*inverse)
            xi, eta = x[i, 0]*inverse - column, x[i, 1]*inverse - row
            k = row*(nx + 1) + column
            l = k + nx + 1
            s = dt*inverse
            l11 = s*((1 - eta)*(p[k + 1, 0] - p[k, 0]) + eta*(p[l + 1, 0] - p[l, 0]))
            l12 = s*((1 - xi)*(p[l, 0] - p[k, 0]) + xi*(p[l + 1, 0] - p[k + 1, 0]))
            l21 = s*((1 - eta)*(p[k + 1, 1] - p[k, 1]) + eta*(p[l + 1, 1] - p[l, 1]))
            l22 = s*((1 - xi)*(p[l, 1] - p[k, 1]) + xi*(p[l + 1, 1] - p[k + 1, 1]))
            h11, h12, h21, h22 = h[i, 0], h[i, 1], h[i, 2], h[i, 3]
            h[i, 0] = g11 = h11 + (l11 + l11*h11 + l12*h21)
            h[i, 1] = g12 = h12 + (l12 + l11*h12 + l12*h22)
            h[i, 2] = g21 = h21 + (l21 + l21*h11 + l22*h21)
            h[i, 3] = g22 = h22 + (l22 + l21*h12 + l22*h22)
            pressure, b = lam*(g11 + g22), volume[i]*inverse
            t11, t22, t12 = b*(pressure + 2*mu*g11), b*(pressure + 2*mu*g22), b*mu*(g12 + g21)
            f[k, 0] += (1 - eta)*t11 + (1 - xi)*t12
            f[k, 1] += (1 - eta)*t12 + (1 - xi)*t22
            f[k + 1, 0] += xi*t12 - (1 - eta)*t11
            f[k + 1, 1] += xi*t22 - (1 - eta)*t12
            f[l, 0] += eta*t11 - (1 - xi)*t12
            f[l, 1] += eta*t12 - (1 - xi)*t22
            f[l + 1, 0] -= eta*t11 + xi*t12
            f[l + 1, 1] -= eta*t12 + xi*t22
        divide(f, nodal_mass)
        for i in range(len(mass)):
            column, row = int(x[i, 0]*inverse), int(x[i, 1]*inverse)
            xi, eta = x[i, 0]*inverse - column, x[i, 1]*inverse - row
            k = row*(nx + 1) + column
            l = k + nx + 1
            w0, w1, w2, w3 = (1 - xi)*(1 - eta), xi*(1 - eta), (1 - xi)*eta, xi*eta
            for d in range(2):
                dv = dt*(w0*f[k, d] + w1*f[k + 1, d] + w2*f[l, d] + w3*f[l + 1, d])
                x[i, d] += dt*(w0*p[k, d] + w1*p[k + 1, d] + w2*p[l, d] + w3*p[l + 1, d] + dv)
                v[i, d] += dv


@njit(inline="always")
def map_to(k, m, v1, v2, nodal_mass, p):
    """Add a mass and its momentum to a node."""
    nodal_mass[k] += m
    p[k, 0] += m*v1
    p[k, 1] += m*v2


@njit(inline="always")
def divide(sums, nodal_mass):
    """Momentum to velocity, or force to acceleration."""
    for k in range(len(nodal_mass)):
        if nodal_mass[k] > 0:
            sums[k, 0] /= nodal_mass[k]
            sums[k, 1] /= nodal_mass[k]
