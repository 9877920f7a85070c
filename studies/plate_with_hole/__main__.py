"""``python -m studies.plate_with_hole``."""

from __future__ import annotations

import sys

from studies.harness.front import main
from studies.plate_with_hole.study import STUDY

if __name__ == "__main__":
    sys.exit(main(STUDY))
