"""``python -m studies.punch_cloud``."""

from __future__ import annotations

import sys

from studies.harness.front import main
from studies.punch_cloud.study import STUDY

if __name__ == "__main__":
    sys.exit(main(STUDY))
