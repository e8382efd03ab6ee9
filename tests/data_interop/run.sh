#!/usr/bin/env bash
# Exported data sets in LeRobot, robomimic and Minari, each in a virtual environment of its own.
# LeRobot's takes 8 GB and many minutes. One of them alone: tests/data_interop/run.sh minari
# LeRobot needs Python 3.12 or later: PYTHON=python3.13 tests/data_interop/run.sh lerobot
# The folder of the environments can be given, to use them again: VENVS=FOLDER tests/data_interop/run.sh
set -euo pipefail
cd "$(dirname "$0")/../.."
export PIP_DISABLE_PIP_VERSION_CHECK=1 HF_HUB_OFFLINE=1
unset PYTHONPATH

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
[ $# -gt 0 ] || set -- lerobot robomimic minari

for library in "$@"; do
  here=tests/data_interop/in_$library
  venv=${VENVS:-$scratch}/$library
  case $library in
    lerobot) python=${PYTHON:-python3.12} packages="lerobot[training,evaluation]" ;;
    minari) python=python3 packages="minari[hdf5] pillow" ;;
    # The imports of robomimic 0.3.0 need six, which it does not ask for.
    *) python=python3 packages="$library six" ;;
  esac
  [ -x "$venv/bin/python" ] || "$python" -m venv "$venv"
  # shellcheck disable=SC2086  # two packages are two words
  "$venv/bin/pip" install --quiet ".[data,render]" pytest $packages -c "$here/constraints.txt"
  "$venv/bin/python" -m pytest -q -c /dev/null --rootdir "$here" \
    --confcutdir tests/data_interop -p no:cacheprovider "$here"
done
