# Picture of the dynamic energy release rate G(t)/G_ref of one or more hampm results, with gnuplot (5.2 or later):
#
#     gnuplot -c postprocess/g_of_t.gp OUT.png FILE.h5 [FILE2.h5 ...]
#
# OUT ends in .png or .svg. From the environment:
#     HAMPM_PYTHON     python with h5py that reads the results (default python3)
#     HAMPM_ESTIMATOR  column of G to draw, * and ? allowed (default G_*)
#     HAMPM_CONVERGED  converged static G/G_ref, drawn as a horizontal line
# The beam on an elastic foundation, eq. (33), is drawn as the first file knows it.

environment(name, default) = system(sprintf("printf %%s \"${%s:-%s}\"", name, default))

# Names of files and columns are texts for the shell and for the picture: a quote in one ends and begins the quotes around it
escaped(text) = strstrt(text, "'") == 0 ? text : text[1:strstrt(text, "'") - 1] . "'\\''" . escaped(text[strstrt(text, "'") + 1:*])
quoted(text) = "'" . escaped(text) . "'"
stem(path) = system("basename -- " . quoted(path) . " .h5")
label(column) = strstrt(column, "_") == 0 ? column : column[1:strstrt(column, "_") - 1] . " " . label(column[strstrt(column, "_") + 1:*])

folder = system("dirname " . quoted(ARG0))
export = quoted(environment("HAMPM_PYTHON", "python3")) . " " . quoted(folder . "/export.py") . " --normalised "
estimator = environment("HAMPM_ESTIMATOR", "G_*")
converged = environment("HAMPM_CONVERGED", "")

if (ARGC < 2) {
    print "usage: gnuplot -c g_of_t.gp OUT.png|OUT.svg FILE.h5 [FILE2.h5 ...]"
    exit status 2
}
suffix = strlen(ARG1) > 4 ? ARG1[strlen(ARG1)-3:*] : ""
if (suffix eq ".png") {
    set terminal pngcairo size 1260,840 fontscale 1.5 linewidth 2 dashlength 1.5 enhanced
} else { if (suffix eq ".svg") {
    set terminal svg size 630,420 fontscale 0.85 dashlength 1.5 background "white" enhanced
} else {
    print sprintf("g_of_t.gp: %s does not end in .png or .svg", ARG1)
    exit status 2
}}

# One curve for every estimator of every file: its command for the data, and its label.
array command[64]
array title[64]
curves = 0
do for [argument = 2:ARGC] {
    file = ARGV[argument]
    columns = system(export . quoted(file) . " --list --columns " . quoted(estimator))
    if (GPVAL_SYSTEM_ERRNO != 0) { exit status GPVAL_SYSTEM_ERRNO }
    do for [column in columns] {
        curves = curves + 1
        command[curves] = "< " . export . quoted(file) . " --columns " . quoted(column)
        title[curves] = stem(file) . ": " . (column[3:6] eq "vcct" ? "VCCT" . label(column[7:*]) : label(column[3:*]))
    }
}
beam = system(export . quoted(ARG2) . " --attribute G_beam_on_foundation 2>/dev/null")

# Okabe and Ito's palette, told apart with any colour vision; the dashes keep it legible in grey.
set linetype 1 linecolor rgb "#0072B2" linewidth 2.2 dashtype solid
set linetype 2 linecolor rgb "#D55E00" linewidth 1.4 dashtype (12,4)
set linetype 3 linecolor rgb "#009E73" linewidth 1.4 dashtype (6,6)
set linetype 4 linecolor rgb "#CC79A7" linewidth 1.4 dashtype (12,4,2.5,4)
set linetype 5 linecolor rgb "#E69F00" linewidth 1.4 dashtype (2.5,3.5)
set linetype 6 linecolor rgb "#56B4E9" linewidth 1.4 dashtype (18,6)
set linetype cycle 6

set output ARG1
set border 3
set tics nomirror out
set grid linecolor "#e6e6e6" linetype 1 linewidth 0.6
set xlabel "time {/:Italic t} [ms]"
set ylabel "energy release rate {/:Italic G}/{/:Italic G}_{ref} [–]"
set xrange [0:*]
set key below center vertical maxrows (curves + 3) / 2 Left reverse samplen 3 height 0.6 noenhanced

plot for [i = 1:curves] command[i] using ($1 * 1e3):2 with lines linetype i title title[i], \
     (strlen(converged) ? real(converged) : NaN) with lines linewidth 1.2 linecolor rgb "#a6a6a6" dashtype solid \
         title (strlen(converged) ? sprintf("converged static value: %.4g", real(converged)) : ""), \
     (strlen(beam) ? real(beam) : NaN) with lines linewidth 1 linecolor rgb "#404040" dashtype (8,5) \
         title (strlen(beam) ? sprintf("beam on elastic foundation: %.4g", real(beam)) : "")
