#!/bin/sh
# Draw the pictures of the docs in results/: all of tools/figures.txt, or those named.
#
#     tools/figures.sh PROGRAM PYTHON [--docs] [FIGURE...]
#
# With --docs the pictures in the docs are replaced by them, a .png with at most 256 colours. FIGURE is a name of the second column of the
# table; the others are listed by --list. One that no function below draws is left to `make` by that name, if what it draws is missing.
set -eu

cd "$(dirname "$0")/.."
program=$1
python=$2
shift 2
out=results/figures
table=tools/figures.txt

main() {
    case ${1:-} in
        --list) figures && return ;;
        --docs) into_docs=yes && shift ;;
        *) into_docs=no ;;
    esac
    mkdir -p $out
    for figure in ${*:-$(figures)}; do
        figures | grep -qx "$figure" || fail "no figure '$figure'; there are $(figures | tr '\n' ' ')"
        echo "figure $figure"
        draw "$figure"
        [ $into_docs = no ] || replace "$figure"
    done
}

fail() {
    echo "figures.sh: $*" >&2
    exit 2
}

# Rows of the table without comments
rows() { sed 's/#.*//; /^[[:space:]]*$/d' $table; }

figures() { rows | awk '!seen[$2]++ {print $2}'; }

# draw FIGURE
draw() {
    if command -v "draw_$1" >/dev/null; then
        "draw_$1"
    else
        missing=
        for file in $(rows | awk -v figure="$1" '$2 == figure {print $3}'); do
            [ -f "$file" ] || missing=yes
        done
        [ -z "$missing" ] || make --no-print-directory "$1"
    fi
}

# replace FIGURE: its pictures in the docs
replace() {
    rows | awk -v figure="$1" '$2 == figure && $1 != "-" {print $3, $1}' | while read -r drawn picture; do
        case $drawn in
            *.svg) sed '/^<svg/s/pt"/px"/g' "$drawn" >"$picture" ;; # letters as large as those of the text
            *) "$python" tools/palette.py "$drawn" "$picture" ;;
        esac
    done
}

# run CASE RESULT [OVERRIDE...]
run() {
    case=$1
    result=$2
    shift 2
    for override; do
        shift
        set -- "$@" --set "$override"
    done
    "$program" "$case" --output $out --force --set "output.file=$result.h5" "$@"
}

plot() { "$python" postprocess/plot_g.py --dpi 150 "$@"; }

# The scene of the README: G(t), where its energy goes, and its stress at the peak and at the end
draw_dcb() {
    run input/dcb.nml dcb
    plot $out/dcb.h5 --converged 1.28737 --output $out/dcb_G.png
    "$python" postprocess/plot_energy.py $out/dcb.h5 --dpi 120 --output $out/dcb_energy.png
    "$python" postprocess/plot_field.py $out/dcb.h5 --field stress_xx --time 2e-4 --time 1.5e-3 --scale 1000 --dpi 120 \
        --output $out/dcb_field.png
}

# The mesh around the tip for three R_crit, and how one of them comes about
draw_mesh() {
    run input/dcb_mesh.nml mesh_r024 refine.r_crit=0.24
    run input/dcb_mesh.nml mesh_r012 refine.r_crit=0.12 refine.max_level=1
    run input/dcb_mesh.nml mesh_r003
    for r in 024 012 003; do
        "$python" postprocess/plot_mesh.py --dpi 120 $out/mesh_r$r.h5 -o $out/mesh_r$r.png
    done
    "$python" postprocess/plot_mesh.py --dpi 120 $out/mesh_r024.h5 $out/mesh_r012.h5 $out/mesh_r003.h5 -o $out/mesh.png
    "$python" postprocess/animate.py $out/mesh_r003.h5 --window 12
}

# The paper's Fig. 10: four methods, by the paper's estimator and by J
draw_fig10() {
    for method in unmodified unlumped adaptive adaptive_unlumped; do
        run input/fig10_$method.nml $method
    done
    set -- $out/unmodified.h5 $out/unlumped.h5 $out/adaptive.h5 $out/adaptive_unlumped.h5
    "$python" tools/figure_10_picture.py docs/evidence/figure_10_paper.csv "$@" --output $out/fig10.png
    "$python" postprocess/tabulate.py "$@" --converged 1.28737
}

# The double cantilever beam comes to rest: estimators that converge, on uniform and refined cells, both plane conditions
draw_dcb_static() {
    for plane in stress strain; do
        run tests/regression/dcb_static/case.nml uniform_$plane run.plane=$plane
        run tests/regression/dcb_static/case.nml refined_$plane run.plane=$plane refine.indicator=tip \
            refine.rings=8 refine.max_level=2
    done
    plot $out/uniform_stress.h5 $out/refined_stress.h5 --estimator vcct_I --estimator domain_I --converged 1.28737 \
        --output $out/dcb_static_stress.png --title 'Plane stress, critically damped'
    plot $out/uniform_strain.h5 $out/refined_strain.h5 --estimator vcct_I --estimator domain_I --converged 1.17150 \
        --output $out/dcb_static_strain.png --title 'Plane strain, critically damped'
    "$python" postprocess/tabulate.py $out/uniform_stress.h5 $out/refined_stress.h5 --converged 1.28737
    "$python" postprocess/tabulate.py $out/uniform_strain.h5 $out/refined_strain.h5 --converged 1.17150
}

# Estimated errors against true ones, from the tables beside the picture, which `make -C bench estimates` measures
draw_estimates() {
    "$python" tools/estimate_picture.py docs/evidence/estimates_before.csv docs/evidence/estimates_after.csv --output $out/estimates.png
}

# What runs reach that are asked for an error, and what they cost, from the table of bench/accuracy.py --csv
draw_accuracy() {
    "$python" tools/accuracy_picture.py docs/evidence/accuracy_models.csv --output $out/accuracy.png
}

# Its vibration, undamped and damped, against finite elements
draw_dcb_dynamic() {
    for rate in 0 1e4; do
        name=$([ $rate = 0 ] && echo undamped || echo alpha10000)
        run tests/regression/dcb_dynamic/case.nml dcb_$name damping.rate=$rate
        run tests/regression/dcb_dynamic/case.nml dcb_${name}_refined damping.rate=$rate refine.indicator=tip \
            refine.rings=8 refine.max_level=2 method.courant=0.8
        plot $out/dcb_$name.h5 $out/dcb_${name}_refined.h5 --estimator domain_I --lowpass 5e4 \
            --reference tests/reference/dcb_dynamic_$name.csv --reference-name 'finite elements' --output $out/dcb_dynamic_$name.png
    done
}

# K_I(t) of an input file and on cells of 0.2 mm refined at the tip: its name, these cells, scale, axis, what the reference is
intensity() {
    run input/$1.nml $1
    run input/$1.nml $1_refined grid.cell=0.2e-3 grid.cells=$2 refine.indicator=tip refine.rings=12 refine.max_level=1
    plot $out/$1.h5 $out/$1_refined.h5 --column K_I --scale $3 --label "$4" --reference tests/regression/$1/reference.csv \
        --reference-name "$5" --time-unit us --output $out/$1_K.png
}

# shellcheck disable=SC2016 # not shell, but mathematics
draw_chen() { intensity chen 51,101 86832 '$K_I / \sigma_0 \sqrt{\pi a}$' 'finite elements'; }

# shellcheck disable=SC2016
draw_freund() { intensity freund 100,51 128958 '$K_I(t) / K_I(2.6\,H/c_d)$' 'closed form'; }

# Two strain gauges beside a crack that a wave meets
draw_gauge() {
    run input/strain_gauge.nml strain_gauge
    plot $out/strain_gauge.h5 --column strain_near --column strain_far --scale 1e-6 --label 'strain [1e-6]' --time-unit us --output $out/strain_gauge.png
}

# Both modes of a split beam under a moment on one arm come to rest
draw_solid_front() {
    make --no-print-directory program dim=3
    mkdir -p $out/solid
    build/release3d/hampm3d input/solid/dcb.nml --output $out/solid --force --quiet
    "$python" postprocess/plot_front.py $out/solid/dcb.h5 --ligament ligament --scale 4.285714e-3 --reference tests/reference/solid/dcb.csv \
        --output $out/solid_front.png
    "$python" tools/solid_dcb.py $out/solid/dcb.h5 $out/solid_dcb.png
    sed -n '/^&run  /,/^```$/p' docs/tutorials/solids.md | sed '$d' >$out/solid/beam.nml
    build/release3d/hampm3d $out/solid/beam.nml --output $out/solid --force --quiet
    "$python" postprocess/plot_field.py $out/solid/beam.h5 --field von_mises --scale 500 --width 5 --dpi 100 --output $out/solid_beam.png
    build/release3d/hampm3d input/solid/plate.nml --output $out/solid --force --quiet
    "$python" postprocess/plot_front.py $out/solid/plate.h5 --over z --scale 0.5293609 --reference tests/reference/solid/plate.csv --output $out/solid_plate.png
    build/release3d/hampm3d input/solid/fatigue_ellipse.nml --output $out/solid --force --quiet
    "$python" postprocess/plot_front.py $out/solid/fatigue_ellipse.h5 --fronts 6 --dpi 100 --output $out/solid_fatigue_ellipse.png
    build/release3d/hampm3d input/solid/ball.nml --output $out/solid --force --quiet
    "$python" postprocess/plot_field.py $out/solid/ball.h5 --field von_mises --slice y=0.0003 --time 6e-5 --width 5 --dpi 100 --output $out/solid_ball.png
}
draw_mixed_mode() {
    run input/mixed_mode.nml mixed_mode
    plot $out/mixed_mode.h5 --estimator 'G_vcct_*' --estimator 'G_domain_*' --converged '3/5.25=0.5714' --converged='-2.25/5.25=-0.4286' \
        --output $out/mixed_mode_G.png
}

# Cracks that grow: two that pass each other at rest, one in a strip, and that of a plate that is hit
draw_growth() {
    for scene in two_cracks strip_growth kalthoff; do
        run input/$scene.nml $scene
        "$python" postprocess/plot_field.py $out/$scene.h5 --field von_mises --width 5 --dpi 85 --output $out/$scene.png
    done
    run input/hole_growth.nml hole_growth
    "$python" postprocess/plot_field.py $out/hole_growth.h5 --field von_mises --snapshot 5 --snapshot 16 --width 6.5 --dpi 85 \
        --output $out/hole_growth.png
    run input/merging_cracks.nml merging_cracks
    "$python" postprocess/plot_field.py $out/merging_cracks.h5 --field von_mises --snapshot 9 --snapshot 11 --width 6.5 --dpi 85 \
        --output $out/merging_cracks.png
    run input/in_situ_stress.nml in_situ_stress
    "$python" postprocess/plot_path.py $out/in_situ_stress.h5 --beside load_factor --window 76 --dpi 75 --output $out/in_situ_stress.png
    "$python" postprocess/plot_path.py $out/strip_growth.h5 --beside G --time-unit us --scale 1000 --dpi 110 --output $out/growth.png
}

# Load over displacement of a load frame: two beams that snap back, a specimen that is unloaded once
draw_load_frame() {
    for scene in dcb_snap_back els compact_tension_growth; do
        run input/$scene.nml $scene
    done
    "$python" tools/load_frame.py $out/dcb_snap_back.h5 $out/els.h5 $out/compact_tension_growth.h5 $out/load_frame.png
}

# Cracks that appear in laminates and at notches
draw_nucleation() {
    run input/laminate_cracks.nml laminate_cracks
    "$python" postprocess/plot_field.py $out/laminate_cracks.h5 --field stress_xx --scale 10 --width 5 --dpi 85 --output $out/nucleation_laminate.png
    "$python" tools/nucleation.py "$program" $out $out/nucleation.png
}

# Growth in load cycles: two tips, an overload, and a crack that goes past a hole
draw_fatigue() {
    for scene in fatigue_eccentric_crack fatigue_overload fatigue_hole; do
        run input/$scene.nml $scene
    done
    "$python" tools/fatigue.py $out/fatigue_eccentric_crack.h5 $out/fatigue_overload.h5 $out/fatigue.png
    "$python" postprocess/plot_field.py $out/fatigue_hole.h5 --field von_mises --width 5 --dpi 85 --output $out/fatigue_hole.png
}

# Toughness that varies: resistance curves, mixed-mode bending, weak planes
draw_resistance() {
    for scene in dcb_r_curve dcb_r_curve_slow laminate_mmb_growth zigzag pmma_strip; do
        run input/$scene.nml $scene
    done
    "$python" tools/resistance.py $out $out/resistance.png
    "$python" tools/branching.py $out/pmma_strip.h5 $out/branching.png
}

# Tests as laboratories do them: a specimen that is hit on its anvils, a plate that a bar hits, wing cracks under compression, and a wedge
draw_impact() {
    for scene in charpy kalthoff_striker wing_cracks; do
        run input/$scene.nml $scene
        "$python" postprocess/plot_field.py $out/$scene.h5 --field von_mises --width 5 --dpi 85 --output $out/$scene.png
    done
    run input/charpy.nml charpy_through growth.toughness=1.0e3 # of a brittle specimen, which parts
    "$python" postprocess/plot_field.py $out/charpy_through.h5 --scale 8 --field von_mises --width 5 --dpi 85 --output $out/charpy_through.png
    run input/one_point_bend.nml one_point_bend
    "$python" tools/references/one_point_bend.py $out/one_point_bend.h5 $out/one_point_bend.png
    run input/wedge_dcb.nml wedge_dcb
    "$python" postprocess/plot_field.py $out/wedge_dcb.h5 --field stress_xx --width 5 --dpi 85 --output $out/wedge_dcb.png
}

# G over the toughness of tips and fronts in strips, and what their faces take; a quarter of an hour
draw_law() {
    "$python" bench/growth.py law --output $out
}

# A film that peels as it is heated, and a crack that a wedge drives
draw_peel() {
    run input/peeling_film.nml peeling_film
    "$python" postprocess/plot_field.py $out/peeling_film.h5 --field stress_xx --scale 5 --width 6 --dpi 85 --output $out/peeling_film.png
    [ -f $out/wedge_dcb.h5 ] || run input/wedge_dcb.nml wedge_dcb
    "$python" tools/peel_and_wedge.py $out/peeling_film.h5 $out/wedge_dcb.h5 $out/peel_and_wedge.png
}

# Specimens of the gallery, and one that yields; small pictures of all
draw_gallery() {
    for scene in compact_tension brazilian_disc; do
        run input/$scene.nml $scene
        "$python" postprocess/plot_field.py $out/$scene.h5 --field von_mises --width 5 --dpi 85 --output $out/$scene.png
    done
    run input/plastic_notch.nml plastic_notch
    "$python" postprocess/plot_field.py $out/plastic_notch.h5 --field plastic_strain --width 5 --dpi 85 --output $out/plastic_notch.png
    for scene in centre_crack edge_crack two_edge_cracks bend_three_points bend_four_points pressurised_crack plate_with_hole \
                 bimetal interface_crack graded_plate laminate_dcb laminate_enf laminate_mmb laminate_mmb_growth penny dcb_growth \
                 dcb_r_curve dcb_snap_back compact_tension_growth compact_tension_pins dcb_cohesive fatigue_centre_crack; do
        run input/$scene.nml $scene output.snapshot_interval=1
    done
    run input/freund_static.nml freund_static output.snapshot_interval=3.7e-6
    run input/absorbing_wave.nml absorbing_wave run.end_time=16e-6 output.snapshot_interval=16e-6 # the pulse is half way out
    for scene in two_cracks merging_cracks hole_growth in_situ_stress fatigue_eccentric_crack fatigue_hole laminate_cracks v_notch \
                 bend_path strip_growth kalthoff kalthoff_striker charpy wing_cracks peeling_film wedge_dcb dcb zigzag pmma_strip \
                 one_point_bend els; do
        run input/$scene.nml $scene
    done
    for picture in $(rows | awk '/small_/ {print $3}'); do
        scene=${picture#"$out/small_"}
        scene=${scene%.png}
        case $scene in
            laminate* | bimetal | dcb* | peeling_film | wedge_dcb | els) field=stress_xx ;;
            plastic_notch) field=plastic_strain ;;
            absorbing_wave) field=speed ;;
            merging_cracks) field=displacement ;; # nothing is stressed any more
            *) field=von_mises ;;
        esac
        case $scene in bimetal | laminate_dcb | dcb_cohesive | compact_tension_growth | peeling_film | compact_tension_pins) scale=3 ;; dcb) scale=1000 ;; dcb_growth | dcb_snap_back | one_point_bend) scale=50 ;; merging_cracks) scale=60 ;; dcb_r_curve) scale=10 ;; *) scale=1 ;; esac
        "$python" tools/thumbnail.py $out/$scene.h5 "$picture" $field $scale
    done
}

# A crack between two materials: stress, and K over the ratio of the moduli
draw_interface() { "$python" tools/tip_parameter_pictures.py interface "$program" $out; }

# A crack in a graded plate: stress, and K over the gradient
draw_graded() { "$python" tools/tip_parameter_pictures.py graded "$program" $out; }

# Models of lessons and specimens before a run; without the date, so that the same sketch is the same file
draw_sketches() {
    for picture in $(rows | awk '$2 == "sketches" {print $3}'); do
        model=$(basename "$picture" .svg)
        SOURCE_DATE_EPOCH=0 "$python" postprocess/sketch.py "$(find input docs/lessons -name "$model.nml")" --output "$picture"
    done
}

# What runs at the extremes do: minutes, unless `make extremes` has left its tables
draw_stability() {
    [ -f results/extremes/release.csv ] || "$python" bench/extremes.py --output results/extremes
    "$python" bench/extremes.py --output results/extremes --draw 1
}

# What accuracy costs, by the tables beside the page, which `make tradeoff` measures
draw_tradeoff() { "$python" tools/tradeoff_pictures.py docs/evidence --output results/tradeoff; }

# Published numbers beside those of the program, by the table beside the page, which `make benchmarks` measures
draw_benchmarks() { "$python" tests/benchmarks/exam.py --draw $out/benchmarks.png; }

# The pictures of the lessons, by the commands that stand there
draw_lessons() {
    rm -rf results/lessons
    for lesson in docs/lessons/[0-9]*.md; do
        awk '/^## What to see/ {exit} /^```/ {is_command = /^```sh/; next} is_command' "$lesson" | bash
    done
}

main "$@"
