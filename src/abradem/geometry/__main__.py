"""python -m abradem.geometry FILE.stl: write the transfer chute of studies/chute_stl.yaml."""

import sys

from abradem.geometry.chute import transfer_chute
from abradem.geometry.mesh_files import write_stl

if len(sys.argv) != 2:
    sys.exit("usage: python -m abradem.geometry FILE.stl")
write_stl(transfer_chute(), sys.argv[1])
