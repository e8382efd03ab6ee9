#!/usr/bin/env bash
# The learners beside public implementations, in a virtual environment of its own.
# Its folder can be given, to be used again: benchmarks/peers.sh FOLDER [OPTIONS of learners.py]
set -euo pipefail
cd "$(dirname "$0")/.."
export PIP_DISABLE_PIP_VERSION_CHECK=1
unset PYTHONPATH

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
venv=${1:-$scratch/venv}

[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
. "$venv/bin/activate"
# AgileRL imports PEFT without asking for it; the last three are what XuanCe's learners import.
pip install --quiet -e ".[train]" agilerl peft torchrl imageio pyglet tensorboard \
    -c benchmarks/peers-constraints.txt
# XuanCe asks for NumPy 1 and much else; its MADDPG runs with NumPy 2, which the others need.
pip install --quiet --no-deps xuance -c benchmarks/peers-constraints.txt

python benchmarks/learners.py --peers "${@:2}"
