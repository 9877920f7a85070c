"""``python -m studies.clouds``."""

import sys

from studies.clouds import run

if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
