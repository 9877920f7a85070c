"""``python -m sphsolid``: the same as the command ``sphsolid``."""

import sys

from sphsolid.shell import main

if __name__ == "__main__":
    sys.exit(main())
