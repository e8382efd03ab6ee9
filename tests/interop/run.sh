#!/usr/bin/env bash
# Environments under Stable-Baselines3, SuperSuit, TorchRL and RLlib, in a virtual environment of its own.
# Its folder can be given, to be used again: tests/interop/run.sh FOLDER
set -euo pipefail
cd "$(dirname "$0")/../.."
export PIP_DISABLE_PIP_VERSION_CHECK=1
unset PYTHONPATH

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
venv=${1:-$scratch/venv}

[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
. "$venv/bin/activate"
# RLlib without its extra, which asks for gymnasium 1.2.2 exactly; what else the extra holds follows.
pip install --quiet -e ".[test]" torch stable-baselines3 supersuit torchrl \
    ray dm-tree lz4 ormsgpack pandas pyarrow scipy tensorboardX \
    -c tests/interop/constraints.txt

# Ray keeps files in the home folder.
HOME=$scratch RAY_USAGE_STATS_ENABLED=0 pytest tests/interop "${@:2}"
