"""Bodies that meet: the scenes of docs/explanation/contact.md, what is measured in their results, and what that should be.

    bars    two elastic bars of length 1 and wave speed 1 run into each other end to end with the speeds v: each loses its motion
            to a wave and gets the opposite one back, so that they part after the time 2, each with its speed turned around
    block   a block slides down a plane with the acceleration g (sin a - mu cos a), or stays where tan a < mu
    discs   two elastic discs meet head on (Sulsky, Chen & Schreyer 1994, section 5.2)
    drop    a weight falls on a beam with a notch: K_I over time
    hertz   a disc pressed on a large body: half-width of the contact a = sqrt(4 F R/(pi E*)), pressure p0 = 2 F/(pi a) in its middle
            (Hertz; Johnson 1985, section 4.2), and the stress below by McEwen's formulas (1949)
"""

import math

import h5py
import numpy as np
from program_runs import run_scene

BARS = """
&run plane = 'stress' end_time = {end} /
&grid lower = 0.0, 0.0 cell = {h} cells = {cells}, 1 /
&material name = 'm' young = 1.0 density = 1.0 poisson = 0.0 /
&body material = 'm' lower = {x0}, 0.0 upper = {x1}, {h} velocity = {v}, 0.0 /
&body material = 'm' lower = {x2}, 0.0 upper = {x3}, {h} velocity = -{v}, 0.0 /
&constraint lower = 0.0, 0.0 upper = {width}, {h} fix = 'y' /
&contact bodies = 'frictionless' /
&method frame = 'updated' /
&output history_interval = {sample} snapshot_interval = {end} /
"""
BLOCK = """
&run plane = 'strain' end_time = {end} /
&grid lower = -0.05, 0.0 cell = 0.05 cells = 34, 12 /
&material name = 'm' young = 1e7 poisson = 0.2 density = 1000.0 /
&body material = 'm' lower = 0.0, 0.05 upper = 1.6, 0.2 /
&body material = 'm' lower = 0.5125, 0.2 upper = 0.9125, 0.4 /
&constraint lower = -0.05, 0.0 upper = 1.65, 0.05 fix = 'xy' /
&load kind = 'gravity' acceleration = {along}, {down} history = 'ramp' rise_time = 0.02 /
&contact bodies = {contact} /
&method frame = 'updated' /
&output history_interval = {sample} snapshot_interval = {half} /
"""
DISCS = """
&run plane = 'strain' end_time = {end} /
&grid lower = 0.0, 0.0 cell = {h} cells = {n}, {n} /
&material name = 'm' law = 'neo_hookean' young = 1000.0 poisson = 0.3 density = 1000.0 /
&body material = 'm' shape = 'circle' center = 0.2, 0.2 radius = 0.2 velocity = {v}, {v} /
&body material = 'm' shape = 'circle' center = 0.8, 0.8 radius = 0.2 velocity = -{v}, -{v} /
&contact bodies = {contact} /
&method frame = 'updated' /
&output history_interval = {sample} snapshot_interval = {end} /
"""
HERTZ = """
&run plane = 'strain' end_time = {end} /
&grid lower = 0.0, 0.0 cell = {h} cells = {nx}, {ny} /
&material name = 'm' law = 'neo_hookean' young = 1e6 poisson = 0.3 density = 1000.0 /
&body material = 'm' lower = {h}, {h} upper = {right}, {top} /
&body material = 'm' shape = 'circle' center = {middle}, {center} radius = 1.0 /
&constraint lower = 0.0, 0.0 upper = {width}, {h} fix = 'xy' /
&load kind = 'body' force = 0.0, -{force} lower = {left}, {above} upper = {width}, {highest} history = 'ramp' rise_time = {rise} /
&damping rate = 22.0 /
&contact bodies = 'frictionless' /
&method frame = 'updated' /
&output history_interval = {sample} snapshot_interval = {end} /
"""
# Steel, a beam of 200 by 40 mm on supports 160 mm apart, with a notch half as deep as the beam
DROP = """
&run plane = 'strain' end_time = {end} /
&grid lower = -0.11, -0.01 cell = {h} cells = {nx}, {ny} /
&material name = 'm' young = 200e9 poisson = 0.3 density = 7850.0 /
&body material = 'm' lower = -0.1, 0.0 upper = 0.1, 0.04 /
&body material = 'm' lower = -0.01, {bottom} upper = 0.01, {top} velocity = 0.0, -{v} /
&constraint lower = -0.08, 0.0 upper = -0.08, 0.0 fix = 'y' /
&constraint lower = 0.08, 0.0 upper = 0.08, 0.0 fix = 'y' /
&crack {crack} /
&contact bodies = 'frictionless' /
&method frame = 'updated' mass = 'weighted' /
&energy_release estimators = 'domain_integral' /
&output history_interval = {sample} snapshot_interval = {end} /
"""


def bars(program, folder, cells=64, phase=0.0, v=1e-3, options=()):
    """Restitution, time of contact over 2, gap in cells at the first force, and what has become of energy and momentum."""
    h = 1 / cells
    x0 = (5 + phase) * h
    x2 = x0 + 1 + 0.3 * h
    n = math.ceil(x2 / h) + cells + 5
    meet = 0.3 * h / (2 * v)
    end = meet + 2.6
    history, fields = run_scene(program, folder, BARS.format(**{"h": h, "cells": n, "width": n * h, "x0": x0, "x1": x0 + 1, "x2": x2, "x3": x2 + 1,
                                                  "v": v, "end": end, "sample": end / 4000}), options)
    pressed = history["time"][np.abs(history["contact_force_x"]) > 0]
    energy = history["kinetic_energy"] + history["strain_energy"]
    mean = [fields["velocity"][fields["body"] == body, 0].mean() for body in (1, 2)]
    return {"restitution": (mean[1] - mean[0]) / (2 * v), "time": (pressed[-1] - pressed[0]) / 2,
            "onset": 2 * v * (meet - pressed[0]) / h, "energy": energy[-1] / energy[0],
            "contact_loss": history["contact_loss"][-1] / energy[0]}


def block(program, folder, contact, slope=30.0, end=0.2, options=()):
    """Acceleration of a block along a slope in the second half of the time, its force along over that normal to the slope, how far it
    has come, and the energies.

    What it bounces, friction takes from its motion along the slope: the acceleration is that of v_x + mu v_y."""
    g, a = 10.0, math.radians(slope)
    history, fields = run_scene(program, folder, BLOCK.format(**{"along": g * math.sin(a), "down": -g * math.cos(a), "contact": contact, "end": end,
                                                   "sample": end / 200, "half": end / 2}), options)
    with h5py.File(folder / "case.h5") as file:
        particles = file["VTKHDF/particles"]
        first = np.concatenate(([0], np.cumsum(particles["NumberOfPoints"][:])))
        body, velocity = particles["PointData/body"][:].squeeze(), particles["PointData/velocity"][:]
        mean = [velocity[first[k]:first[k + 1]][body[first[k]:first[k + 1]] == 2].mean(axis=0) for k in (1, 2)]
    change = (mean[1] - mean[0]) / (end / 2)
    sums = [history[f"contact_force_{axis}"][100:].sum() for axis in "xy"]
    friction = float(contact.split("=")[1]) if "=" in contact else 0.0
    return {"acceleration": change[0] + friction * change[1], "ratio": -sums[0] / sums[1],
            "way": fields["displacement"][fields["body"] == 2, 0].mean(),
            "friction_loss": history["friction_loss"][-1], "contact_loss": history["contact_loss"][-1]}


def discs(program, folder, h=0.05, v=0.1, contact="'frictionless'", end=4.0, options=()):
    """The history over time of two discs that meet, and the restitution at its end."""
    history, fields = run_scene(program, folder, DISCS.format(**{"h": h, "n": round(1 / h), "v": v, "contact": contact, "end": end,
                                                   "sample": end / 400}), options)
    mean = [fields["velocity"][fields["body"] == body, 0].mean() for body in (1, 2)]
    return history, (mean[1] - mean[0]) / (2 * v)


def below(x, z, p0, a):
    """Stress yy below a Hertzian pressure at the depth z (McEwen 1949)."""
    square = a**2 - x**2 + z**2
    root = np.sqrt(square**2 + 4 * x**2 * z**2)
    m2, n2 = (root + square) / 2, np.maximum(root - square, 0) / 2
    return -p0 / a * np.sqrt(m2) * (1 - (z**2 + n2) / (m2 + n2))


def hertz(program, folder, cells=24, a=0.16, phase=0.0, end=1.2, wide=2.5, options=()):
    """Half-width and greatest pressure of the contact of a disc on a large body, over Hertz's, by the stress in the latter down to the
    depth 2 a; and the force that it takes over that which presses."""
    h, elastic = 1 / cells, 1e6 / (2 * (1 - 0.3**2))
    force = math.pi * a**2 * elastic / 4
    top = (1 + round(0.75 * cells) + phase) * h
    nx = round(wide * cells)
    middle = nx * h / 2
    history, fields = run_scene(program, folder, HERTZ.format(**{
        "h": h, "nx": nx, "ny": math.ceil((top + 2) / h) + 1, "right": (nx - 1) * h, "top": top, "middle": middle, "center": top + 1,
        "width": nx * h, "left": 0.0, "above": top + 1e-6, "highest": top + 2, "force": force, "rise": end / 4, "end": end,
        "sample": end / 100}), options)
    start = fields["place"] - fields["displacement"][:, :2]
    x, z = start[:, 0] - middle, top - start[:, 1]
    near = (fields["body"] == 1) & (z < 2 * a) & (np.abs(x) < 2 * a)
    x, z, stress = x[near], z[near], fields["stress_yy"][near]
    p0 = 2 * force / (math.pi * a)
    best = None
    for width in np.linspace(0.6, 1.5, 901) * a:
        shape = below(x, z, 1.0, width)
        height = shape @ stress / (shape @ shape)
        miss = np.linalg.norm(height * shape - stress)
        if best is None or miss < best[0]:
            best = miss, width, height
    exact = below(x, z, p0, a)
    return {"half_width": best[1] / a, "pressure": best[2] / p0, "stress_error": np.linalg.norm(stress - exact) / np.linalg.norm(exact),
            "force": history["contact_force_y"][-20:].mean() / force}


def drop(program, folder, cell=2.5e-3, gap=0.25e-3, v=5.0, end=100e-6, crack="kind = 'line' tip = 0.0, 0.02 direction = 0.0, 1.0", options=()):
    """History of a notched beam on which a weight falls, and the time at which that must touch it."""
    n = round(0.22 / cell), round(0.09 / cell)
    history, _ = run_scene(program, folder, DROP.format(**{"h": cell, "nx": n[0], "ny": n[1], "end": end, "sample": end / 400, "v": v,
                                             "crack": crack, "bottom": 0.04 + gap, "top": 0.07 + gap}), options)
    return history, gap / v
