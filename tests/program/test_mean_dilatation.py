"""One dilatation a cell, `&material volumetric = 'b_bar'`, of every law, in every integrator and frame: a beam that hardly changes its volume."""

import numpy as np
import pytest

import harness

ISOTROPIC = "young = 1e6  poisson = 0.45  law = "
LAWS = {
    "linear_elastic": ISOTROPIC + "'linear_elastic'",
    "orthotropic": "law = 'orthotropic'  young_1 = 1e6  young_2 = 5e5  young_3 = 1e6  poisson_12 = 0.6  poisson_13 = 0.45  poisson_23 = 0.3"
                   "  shear_12 = 3e5",
    "neo_hookean": ISOTROPIC + "'neo_hookean'",
    "mooney_rivlin": ISOTROPIC + "'mooney_rivlin'  c01 = 2e4",
    "j2_plastic": ISOTROPIC + "'j2_plastic'  yield_stress = 80  hardening = 1e5",
    "viscoelastic": ISOTROPIC + "'viscoelastic'  moduli = 1e5  relaxation_times = 0.1",
}
FINITE = "neo_hookean", "mooney_rivlin"
every_law = pytest.mark.parametrize("law", LAWS)


@pytest.fixture
def run(hampm):
    """`run(material, force, *settings)`: the history of a beam that is held at one end and drawn down at the other."""
    def run(material, force, *settings, cell=0.05):
        return harness.run(hampm, f"""
            &material name = 'a'  density = 1000  volumetric = 'b_bar'  {material} /
            &run plane = 'strain'  thickness = 1.0  end_time = 1.0 /
            &grid lower = {-cell}, -1.0  cell = {cell}  cells = {round(1.25/cell)}, {round(1.5/cell)} /
            &body material = 'a'  lower = 0.0, 0.0  upper = 1.0, 0.25 /
            &constraint lower = 0.0, 0.0  upper = 0.0, 0.25  fix = 'xy' /
            &load kind = 'traction'  lower = 1.0, 0.0  upper = 1.0, 0.25  force = 0.0, {-force}  history = 'ramp'  rise_time = 0.2 /
            &damping rate = 0.0 /
            &method frame = 'total' /
            &energy_release energy_balance = .true. /""", *settings)
    return run


def test_a_beam_that_keeps_its_volume_does_not_lock(run):
    """Poisson's ratio 0.4999 at rest, beside quadratic cells, an independent discretisation that does not lock either."""
    at_rest = "method.time=static", "run.plane=strain"
    material = LAWS["linear_elastic"], 4.0, *at_rest, "material.poisson=0.4999"
    reference = run(*material, "material.volumetric=standard", "grid.order=2", "body.points_per_cell=3", cell=0.0125)["strain_energy"][-1]
    shared = [run(*material, cell=cell)["strain_energy"][-1]/reference for cell in (0.05, 0.025, 0.0125)]
    own = run(*material, "material.volumetric=standard", cell=0.0125)["strain_energy"][-1]/reference
    print("\nenergy over that of quadratic cells:", *(f"{value:.4f}" for value in shared), f"without it {own:.4f}")
    assert own < 0.5
    assert shared[-1] == pytest.approx(1, abs=0.01)
    assert abs(shared[2] - 1) < abs(shared[1] - 1) < abs(shared[0] - 1)


def test_quadratic_cells_have_no_use_for_it(run):
    """With them the key is without effect, of which a warning tells."""
    quadratic = LAWS["linear_elastic"], 4.0, "method.time=static", "grid.order=2", "body.points_per_cell=3"
    assert run(*quadratic)["strain_energy"][-1] == run(*quadratic, "material.volumetric=standard")["strain_energy"][-1]


@pytest.mark.parametrize("time", ["static", "implicit time_step=1e-3", "explicit courant=0.1"])
def test_isotropic_constants_make_the_orthotropic_law_the_linear_one(run, time):
    """With the same steps, and not as without one dilatation a cell: the key was silent with this law."""
    time, *step = time.split()
    isotropic = f"{ISOTROPIC}'linear_elastic'"
    orthotropic = ("law = 'orthotropic'  young_1 = 1e6  young_2 = 1e6  young_3 = 1e6  poisson_12 = 0.45  poisson_13 = 0.45  poisson_23 = 0.45"
                   f"  shear_12 = {1e6 / 2.9!r}  angle = 30")
    settings = f"method.time={time}", "run.end_time=0.3", "output.history_interval=0.01", *(f"method.{key}" for key in step)
    got = [run(material, 4.0, *settings, cell=0.125)["strain_energy"][-1] for material in (isotropic, orthotropic)]
    assert got[1] == pytest.approx(got[0], rel=1e-10)
    assert abs(run(orthotropic, 4.0, *settings, "material.volumetric=standard", cell=0.125)["strain_energy"][-1] / got[0] - 1) > 0.05


@every_law
def test_explicit_and_implicit_steps_agree(run, law):
    """Explicit steps of both frames and of both planes, and implicit ones, under a load that rises slowly; displacements are small."""
    slow = "load.rise_time=0.8", "run.end_time=1.2", "damping.rate=30.0", "output.history_interval=0.2"
    force = 2.0
    for plane in "strain", "stress":
        beam = LAWS[law], force, f"run.plane={plane}", *slow
        moved = {frame: run(*beam, f"method.frame={frame}", cell=0.125) for frame in ("total", "updated")}
        energy = {frame: got["strain_energy"][-1] for frame, got in moved.items()}
        if law not in FINITE:
            energy["implicit"] = run(*beam, "method.time=implicit", cell=0.125)["strain_energy"][-1]
        expected = energy.get("implicit", energy["updated"])
        print(f"\n{law}, {plane}:", *(f"{name} {value/expected - 1:.1e}" for name, value in energy.items()))
        assert list(energy.values()) == pytest.approx([expected]*len(energy), rel=2e-3)


@every_law
@pytest.mark.parametrize("frame", ["total", "updated"])
def test_the_energy_of_a_beam_that_swings_is_kept(run, law, frame):
    """The audit of explicit steps closes: to rounding, or of laws with a history to the third order of the step."""
    got = run(LAWS[law], 4.0, f"method.frame={frame}", "run.end_time=0.3", cell=0.125)
    missing = got["kinetic_energy"] + got["strain_energy"] + got["numerical_loss"] - got["external_work"]
    for taken in "plastic_dissipation", "viscous_dissipation":
        missing = missing + got.get(taken, 0.0)
    assert np.max(np.abs(missing)) < (1e-5 if law in ("j2_plastic", "viscoelastic") else 1e-12)*np.max(np.abs(got["external_work"]))
    assert abs(got["numerical_loss"][-1]) < 2e-3*np.max(np.abs(got["external_work"]))


@pytest.mark.parametrize("law", FINITE[:1])
def test_rubber_bends_far_in_both_frames(run, law):
    """Poisson's ratio 0.49 and a tip that sinks by a third of the length; beside quadratic cells at rest. Particles that cross cells
    of this size add to the error of the updated frame."""
    large = LAWS[law], 2500.0, "material.poisson=0.49"
    settled = "damping.rate=12.0", "run.end_time=1.2", "output.history_interval=0.1"
    expected = run(*large, "material.volumetric=standard", "method.time=static", "method.load_steps=10", "grid.order=2",
                   "body.points_per_cell=3")["strain_energy"][-1]
    for frame in "total", "updated":
        got = run(*large, f"method.frame={frame}", *settled)["strain_energy"][-1]/expected
        print(f"\n{law}, {frame}: energy over that of quadratic cells {got:.4f}")
        assert got == pytest.approx(1, abs={"total": 0.03, "updated": 0.08}[frame])
