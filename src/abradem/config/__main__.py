"""python -m abradem.config --write"""

import sys

from abradem.config.reference import main

sys.exit(main(sys.argv[1:]))
