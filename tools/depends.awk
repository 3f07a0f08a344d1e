# Make rules between the objects of Fortran sources, from their `module` and `use` statements:
#
#     awk -f tools/depends.awk src/*/*.f90 > depends.mk        $(O)/hampm_step.mod: $(O)/step.o ;
#                                                              $(O)/step.o: $(O)/hampm_particles.mod $(O)/hampm_grid.mod
#
# An object is named after its source, in the folder -v folder='$(O)'. It depends on the files of the modules that it uses, which
# gfortran leaves alone where the interface is the same: then nothing else is compiled. A submodule depends on the object of its
# ancestor. Modules that no source defines (intrinsic ones, those of libraries) are left out. Any POSIX awk.

BEGIN { if (folder == "") folder = "$(O)" }

FNR == 1 {
    object = FILENAME
    sub(/.*\//, "", object)
    sub(/\.[^.]*$/, ".o", object)
    objects[++count] = object
    continued = ""
}

{
    line = continued tolower($0)
    sub(/\r$/, "", line)
    sub(/^[ \t]+/, "", line)
    if (line !~ /^(use|module|submodule)([^a-z0-9_]|$)/) next  # what else holds a ! or & is no concern
    sub(/!.*/, "", line)
    if (sub(/&[ \t]*$/, " ", line)) { continued = line; next }
    continued = ""
    parts = split(line, statement, ";")
    for (i = 1; i <= parts; i++) read_statement(statement[i])
}

function read_statement(text) {
    gsub(/[ \t&:]+/, " ", text)
    sub(/^ /, "", text)
    sub(/^use ?, ?non_intrinsic /, "use ", text)
    if (sub(/^use /, "", text)) {
        needs(name_of(text))
    } else if (sub(/^submodule ?\( ?/, "", text)) {
        descends[object, name_of(text)] = 1
        needs(name_of(text))
    } else if (text ~ /^module [a-z][a-z0-9_]* ?$/) {
        defined_in[name_of(substr(text, 8))] = object
    }
}

function name_of(text) {
    match(text, /^[a-z][a-z0-9_]*/)
    return substr(text, 1, RLENGTH)
}

function needs(module) { needed_by[object] = needed_by[object] " " module }

END {
    for (module in defined_in) print folder "/" module ".mod: " folder "/" defined_in[module] " ;"
    for (i = 1; i <= count; i++) {
        object = objects[i]
        line = ""
        names = split(needed_by[object], name, " ")
        for (j = 1; j <= names; j++) {
            needed = defined_in[name[j]]
            if (needed == "" || needed == object || (object, name[j]) in written) continue
            written[object, name[j]] = 1
            line = line " " folder "/" ((object, name[j]) in descends ? needed : name[j] ".mod")
        }
        if (line != "") print folder "/" object ":" line
    }
}
