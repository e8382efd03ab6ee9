#!/usr/bin/env bash
# Environments under BenchMARL, in a virtual environment of its own: it needs TorchRL before 0.12.
# Its folder can be given, to be used again: tests/interop/benchmarl.sh FOLDER
set -euo pipefail
cd "$(dirname "$0")/../.."
export PIP_DISABLE_PIP_VERSION_CHECK=1
unset PYTHONPATH

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
venv=${1:-$scratch/venv}

[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
. "$venv/bin/activate"
pip install --quiet -e ".[test]" torch torchrl hydra-core tqdm -c tests/interop/benchmarl.txt
# Without what it asks for besides: torchvision and av, for films that are sent to loggers.
pip install --quiet --no-deps benchmarl -c tests/interop/benchmarl.txt
pytest tests/interop/test_benchmarl.py "${@:2}"
