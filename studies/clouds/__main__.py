"""``python -m studies.clouds``."""

from __future__ import annotations

import sys

from studies.clouds.study import run

if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
