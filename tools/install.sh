#!/bin/sh
# Install the program and what belongs to it, or remove it: what `make install` and `make uninstall` run.
#
#     PREFIX=FOLDER [DESTDIR=FOLDER] [packages="run batch"] tools/install.sh PROGRAM [PROGRAM FOR SOLIDS]
#     PREFIX=FOLDER [DESTDIR=FOLDER] tools/install.sh --uninstall         (without sources: sh PREFIX/share/hampm/tools/install.sh)
#
#     PREFIX/bin             hampm, perhaps hampm3d, and hampm-tool, which runs the scripts
#     PREFIX/share/hampm     postprocess, batch, the Python package, models and sweeps (input), requirements
#     PREFIX/share           man/man1/hampm.1, doc/hampm, completions for bash and zsh
#     PREFIX/lib/hampm/venv  Python with the packages of requirements/PART.txt, of the parts named by `packages` (default: run; none: no Python
#                            is installed, and hampm-tool takes python3). With DESTDIR there are none: packagers bring their own
#
# Files are noted in share/hampm/files, by which they are removed, also before they are installed anew.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
case ${PREFIX:?} in
    /*) ;;
    \~/*) PREFIX=$HOME/${PREFIX#\~/} ;;
    *) PREFIX=$(pwd)/$PREFIX ;;
esac
prefix=${DESTDIR:-}${PREFIX%/}
share=$prefix/share/hampm
venv=$prefix/lib/hampm/venv
list=$share/files

main() {
    if [ "${1-}" = --uninstall ]; then
        [ -f "$list" ] || fail "$list: there is no such file: hampm is not installed in $prefix"
        remove
        [ ! -f "$venv/hampm" ] || rm -r "$venv"
        rmdir "$prefix/lib/hampm" "$prefix/lib" "$prefix" 2>/dev/null || true
        return
    fi
    program=$1
    solid=${2-}
    for file; do
        [ -x "$file" ] || fail "$file: there is no such program"
    done
    [ ! -f "$list" ] || remove
    mkdir -p "$share"
    : >"$list"
    install_files
    install_python
    echo "installed hampm $("$program" --version | cut -d ' ' -f 2-) in $prefix"
}

fail() {
    echo "install.sh: $1" >&2
    exit 1
}

# Remove the files of an installation, and the folders that are then empty.
remove() {
    find "$share" -name __pycache__ -prune -exec rm -r {} +
    while IFS= read -r file; do
        rm -f "$prefix/$file"
        folder=$(dirname "$prefix/$file")
        while [ "$folder" != "$prefix" ] && rmdir "$folder" 2>/dev/null; do
            folder=$(dirname "$folder")
        done
    done <"$list"
    rm -f "$list"
    rmdir "$share" "$prefix/share" 2>/dev/null || true
}

# place MODE FILE PATH: copy a file to PATH below the prefix.
place() {
    mkdir -p "$(dirname "$prefix/$3")"
    cp "$2" "$prefix/$3.part"
    chmod "$1" "$prefix/$3.part"
    mv "$prefix/$3.part" "$prefix/$3"
    echo "$3" >>"$list"
}

# generate KIND PATH: what tools/manual.py makes of the program.
generate() {
    mkdir -p "$(dirname "$prefix/$2")"
    python3 "$root/tools/manual.py" "$program" "$1" >"$prefix/$2"
    chmod 644 "$prefix/$2"
    echo "$2" >>"$list"
}

install_files() {
    place 755 "$program" bin/hampm
    [ -z "$solid" ] || place 755 "$solid" bin/hampm3d
    place 755 "$root/tools/hampm-tool" bin/hampm-tool
    for folder in batch postprocess input requirements tools/upgrade.py tools/install.sh requirements.txt requirements.lock VERSION python; do
        [ ! -e "$root/$folder" ] || (cd "$root" && find "$folder" -name __pycache__ -prune -o -name dist -prune -o -name '*.egg-info' -prune -o -name .pytest_cache -prune -o \
            -type f -print) | while IFS= read -r file; do
            place 644 "$root/$file" "share/hampm/$file"
        done
    done
    for file in README.md CHANGELOG.md LICENSE CITATION.cff docs/reference/keys.md docs/reference/key_rules.md docs/how-to/batches.md docs/how-to/gate.md docs/reference/results.md; do
        place 644 "$root/$file" "share/doc/hampm/$(basename "$file")"
    done
    generate man share/man/man1/hampm.1
    generate bash share/bash-completion/completions/hampm
    generate zsh share/zsh/site-functions/_hampm
}

install_python() {
    parts=${packages:-run}
    if [ -n "${DESTDIR:-}" ] || [ "$parts" = none ]; then
        return
    fi
    set -- -c "$share/requirements.lock"
    for part in $parts; do
        [ -f "$share/requirements/$part.txt" ] || fail "packages: there is no part $part; there are run, batch, docs, test, verify and none"
        set -- "$@" -r "$share/requirements/$part.txt"
    done
    wanted=$(cat "$share/requirements.lock" && echo "$parts")
    if [ "$(cat "$venv/hampm" 2>/dev/null)" != "$wanted" ]; then
        echo "installing the Python packages to $parts into $venv"
        python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { shift 2; }
        python3 -m venv --clear "$venv"
        "$venv/bin/python" -m pip install --quiet --disable-pip-version-check "$@"
        echo "$wanted" >"$venv/hampm"
    fi
    for packages_of in "$venv"/lib/python*/site-packages; do
        [ ! -d "$packages_of" ] || echo "$share/python/src" >"$packages_of/hampm.pth"
    done
}

main "$@"
