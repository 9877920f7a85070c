"""``python -m studies.pareto``."""

from __future__ import annotations

import sys

from studies.harness.front import main
from studies.pareto.study import STUDY

if __name__ == "__main__":
    sys.exit(main(STUDY))
