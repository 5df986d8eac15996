#!/usr/bin/env bash
# Runs in the folder of the Snakefile, in the new environment.
set -eu
"$CONDA_PREFIX/bin/python" -m pip install --constraint constraints.txt --editable .
