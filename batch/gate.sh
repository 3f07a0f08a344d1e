#!/bin/sh
# Run models and hold their results to stored ones, for continuous integration: hampm.postprocess.gate, whose --help lists the options.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
python=${HAMPM_PYTHON:-$root/.venv/bin/python}
[ -n "${HAMPM_PYTHON:-}" ] || [ -x "$python" ] || python=python3
PYTHONPATH="$root/python/src${PYTHONPATH:+:$PYTHONPATH}" exec "$python" -m hampm gate "$@"
