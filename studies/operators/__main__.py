"""``python -m studies.operators``."""

from __future__ import annotations

import sys

from studies.harness.front import main
from studies.operators.study import STUDY

if __name__ == "__main__":
    sys.exit(main(STUDY))
