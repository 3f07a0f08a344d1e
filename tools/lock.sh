#!/bin/sh
# Write requirements.lock: one version of every package that the parts in requirements/ need, for each Python from 3.11.2 on.
#
#     tools/lock.sh            resolve requirements.txt anew, keeping the versions of the lock where they serve; --upgrade: the newest
#     tools/lock.sh --check    resolve the lock for each of the Pythons below from wheels alone, and install nothing; exit code 1
#                              with the reason where that fails, 3 where the index of packages cannot be reached
#
# uv, which resolves for Pythons that are not there, is installed into build/uv.
set -eu

pythons="3.11.2 3.12 3.13 3.14"
# Without a wheel: connection_pool, of Snakemake, is published as sources alone, which are one file of Python
sources="connection-pool"
version=0.13.9
root=$(cd "$(dirname "$0")/.." && pwd)
uv=$root/build/uv/bin/uv

main() {
    cd "$root"
    case "$*" in
        '') bring_uv && lock ;;
        --upgrade) bring_uv && lock --upgrade ;;
        --check) bring_uv && check ;;
        *)
            sed -n '2,8s/^# \{0,1\}//p' "$0" >&2
            exit 2
            ;;
    esac
}

bring_uv() {
    [ "$("$uv" --version 2>/dev/null | cut -d ' ' -f 2)" = "$version" ] && return
    python3 -m venv --clear build/uv
    said=$(build/uv/bin/python -m pip install --quiet --disable-pip-version-check --retries 1 "uv==$version" 2>&1) && return
    echo "lock.sh: uv cannot be installed: $said" >&2
    exit 3
}

# No settings of the user count.
resolve() { "$uv" pip "$@" --no-config --quiet --only-binary :all: --no-binary "$sources"; }

lock() {
    resolve compile --universal --python-version "${pythons%% *}" --fork-strategy fewest --no-annotate \
        --custom-compile-command "make lock" "$@" requirements.txt --output-file requirements.lock >/dev/null
}

check() {
    for python in $pythons; do
        said=$(resolve install --dry-run --no-deps --target build/uv/none --python-version "$python" --requirements requirements.lock 2>&1) || {
            case $said in *"error sending request"* | *"Failed to fetch"* | *"dns error"*) code=3 ;; *) code=1 ;; esac
            printf 'lock.sh: Python %s: %s\n' "$python" "$said" >&2
            exit "$code"
        }
    done
}

main "$@"
