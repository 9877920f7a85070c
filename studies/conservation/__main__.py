"""``python -m studies.conservation``."""

from __future__ import annotations

import sys

from studies.conservation.study import STUDY
from studies.harness.front import main

if __name__ == "__main__":
    sys.exit(main(STUDY))
