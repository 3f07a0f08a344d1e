"""Strength of V-notches in mode I by the coupled criterion (Leguillon 2002), where the crack that appears is short: nothing but the singular field counts.

The stress on the bisector is k r**(lambda - 1), by the exponent of Williams (1952). A crack of length l at the tip has K_I = psi k l**(lambda - 1/2), and
releases G = (psi k)**2 l**(2 lambda - 1)/(2 lambda E') in the mean. So G = K_Ic**2/E' and k l**(lambda - 1) = strength together give

    l = 2 lambda (K_Ic/(psi strength))**2,   k_c = strength l**(1 - lambda).

psi is found by Mellin transforms and the method of Wiener and Hopf. With u r**p and s r**(p - 1) across the bisector, and free faces at +-alpha,

    s = -E'/2 p L(p) u,   L(p) = 2 (sin(p alpha)**2 - p**2 sin(alpha)**2)/(sin(2 p alpha) + p sin(2 alpha)),

which is tan(pi p) of a crack, alpha = pi. With -p L = M+ M-, M+ regular and without zeros where Re p > 0, psi = sqrt(2)/(lambda M+(lambda)); here that of the
crack is M+ = Gamma(p + 1/2)/Gamma(p + 1), times exp(p/pi int_0^inf ln(N(i y))/(y**2 + p**2) dy) with N the quotient of both. Checked: a crack of any length
in line with another one has its K (psi = sqrt(2 pi) at 0 degrees), and one at a straight edge 1.12152226 k sqrt(pi l) (Koiter).
"""

import math

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq


def exponent(angle):
    """Exponent lambda of the displacement, of a notch that is open by an angle [rad]."""
    alpha = math.pi - angle / 2
    if angle <= 0:
        return 0.5
    return 1.0 if angle >= math.pi else brentq(lambda x: math.sin(2 * x * alpha) + x * math.sin(2 * alpha), 0.5, 1 - 1e-9)


def psi(angle):
    """K_I of a crack at the tip of the notch, over k l**(lambda - 1/2)."""
    alpha, x = math.pi - angle / 2, exponent(angle)

    def ratio(y):
        if y < 1e-3:
            return math.log(2 * (alpha**2 - math.sin(alpha)**2) / ((2 * alpha + math.sin(2 * alpha)) * math.pi))
        e = math.exp(-2 * y * alpha)
        above = 2 * (((1 - e) / 2)**2 - (y * math.sin(alpha))**2 * e)
        return math.log(above / ((1 - e * e) / 2 + y * math.sin(2 * alpha) * e) / math.tanh(math.pi * y))

    integral = sum(quad(lambda y: ratio(y) / (y * y + x * x), *part)[0] for part in ((0, 1), (1, 40)))
    return math.sqrt(2) / (x * math.gamma(x + 0.5) / math.gamma(x + 1) * math.exp(x / math.pi * integral))


def onset(angle, k_ic, strength):
    """Length of the crack that appears [m], and k then [Pa m**(1 - lambda)]."""
    x = exponent(angle)
    length = 2 * x * (k_ic / (psi(angle) * strength))**2
    return length, strength * length**(1 - x)


def intensity(distance, stress, angle):
    """k by the stress on the bisector at some distances, with the term behind the singular one, about r**0.6."""
    terms = np.array([distance**(exponent(angle) - 1), distance**0.6]).T / np.asarray(stress)[:, None]
    return np.linalg.lstsq(terms, np.ones(len(distance)), rcond=None)[0][0]
