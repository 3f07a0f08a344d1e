#!/bin/sh
# Run models and hold their results to stored ones: for continuous integration of models, of a new version of hampm, or of a changed program.
#
#     batch/gate.sh [options] REFERENCES MODEL.nml...
#
#     --update             store the results as the references, where all models have run
#     --tolerances FILE    tolerances of cases and columns (postprocess/compare_folders.py has the form); else all agree to 1e-9
#     --output FOLDER      of the results, gate.xml (JUnit) and gate.json; default: gate. It is new, or one of an earlier run, whose results go
#     --threads N          of each run; default: 1
#
# REFERENCES is a folder with a result for each model, MODEL.h5. The environment variables HAMPM and HAMPM_PYTHON name another program and
# another Python. Exit code: 0 all agree; 1 some differ, are missing or have failed; 2 the request makes no sense.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
update='' tolerances='' output=gate threads=1
python=${HAMPM_PYTHON:-$root/.venv/bin/python}
[ -n "${HAMPM_PYTHON:-}" ] || [ -x "$python" ] || python=python3

fail() {
    echo "gate.sh: $1" >&2
    exit 2
}

while [ $# -gt 0 ]; do
    case $1 in
        --help)
            sed -n '2,14s/^# \{0,1\}//p' "$0"
            exit
            ;;
        --update) update=yes ;;
        --tolerances | --output | --threads)
            [ $# -gt 1 ] || fail "$1: its value is missing"
            case $1 in
                --tolerances) tolerances=$2 ;;
                --output) output=$2 ;;
                --threads) threads=$2 ;;
            esac
            shift
            ;;
        --*) fail "there is no option $1; --help lists them" ;;
        *) break ;;
    esac
    shift
done
[ $# -gt 1 ] || fail "REFERENCES and models are needed; --help explains"
references=$1
shift
hampm=${HAMPM:-$("$python" -c 'import sys; sys.path.insert(0, sys.argv[1]); from hampm.program import program_of_scripts; print(program_of_scripts())' "$root/python/src")}
if [ -d "$output" ] && [ ! -f "$output/gate.json" ] && [ -n "$(ls -A "$output")" ]; then
    fail "$output: has files of others; name another folder"
fi
mkdir -p "$output"
echo '{}' >"$output/gate.json"
rm -f "$output"/*.h5 "$output/gate.xml"

failed=0
for model in "$@"; do
    name=$(basename "$model" .nml)
    [ ! -e "$output/$name.h5" ] || fail "$name: two models have this name"
    code=0
    "$hampm" "$model" --quiet --threads "$threads" --output "$output" --set "output.file=$name.h5" >"$output/$name.log" 2>&1 || code=$?
    if [ "$code" != 0 ]; then
        echo "$name: failed with exit code $code: $(tail -n 1 "$output/$name.log")"
        rm -f "$output/$name.h5"
        failed=$((failed + 1))
    fi
done

if [ -n "$update" ]; then
    [ "$failed" = 0 ] || exit 1
    mkdir -p "$references"
    cp "$output"/*.h5 "$references/"
    echo "$# references in $references"
    exit
fi
code=0
"$python" "$root/postprocess/compare.py" "$references" "$output" --finite --only-differences --json "$output/gate.json" --junit "$output/gate.xml" \
    ${tolerances:+--tolerances "$tolerances"} || code=$?
[ "$code" != 0 ] || [ "$failed" = 0 ] || code=1
exit "$code"
