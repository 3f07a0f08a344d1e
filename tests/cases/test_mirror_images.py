"""Mirror images are the same scenes."""

import pytest

# What rounding makes of results that are the same but for the order of sums, over the largest value of a column
ROUNDING = 1e-7
EVEN = ["K_I", "J", "strain_energy", "kinetic_energy", "external_work", "crack_opening", "mouth_opening"]
ODD = ["K_II", "crack_sliding", "mouth_sliding"]


@pytest.mark.parametrize("change", [
    {}, {"-0.001, -0.0012, ": "", "0.001, -0.0012, ": ""}, {"points_per_cell = 3": "points_per_cell = 4"},
    {"time = 'explicit'": "time = 'implicit'  time_step = 6e-7"}, {"order = 2": "order = 1", "  mass = 'consistent'": ""}])
def test_k_of_mirror_images_in_motion(case, text_of, change):
    rows = []
    for name in ("quadratic_motion_mirror_a", "quadratic_motion_mirror_b"):
        text = text_of(name).replace("end_time = 6e-06", "end_time = 1.8e-06")
        for old, new in change.items():
            text = text.replace(old, new)
        result = case(name, text=text)
        assert result.code == 0, result.stderr
        rows.append(result.row)
    a, b = rows
    for columns, sign in ((EVEN, 1), (ODD, -1)):
        for column in columns:
            assert a[column] == pytest.approx(sign * b[column], rel=0, abs=ROUNDING * max(abs(a[column]))), column


def test_cohesive_points_half_way_between_others(case, text_of):
    text = text_of("cohesive_points_half_way")
    mirrored = text.replace("-0.129096790440258", "0.129096790440258").replace("-0.0808486015947118", "0.0808486015947118").replace("-2.32e-6", "2.32e-6").replace("-0.095", "0.095")
    a, b = (case("cohesive_points_half_way", text=one).row for one in (text, mirrored))
    assert a["cells"][-1] > a["cells"][0] and a["crack_length"][-1] > 0.2
    for column in ("J", "J_tip2", "strain_energy", "kinetic_energy", "fracture_energy", "external_work", "crack_opening"):
        assert a[column] == pytest.approx(b[column], rel=0, abs=ROUNDING * max(abs(a[column]))), column
