"""``python -m studies.twisting_column``."""

from __future__ import annotations

import sys

from studies.harness.front import main
from studies.twisting_column.study import STUDY

if __name__ == "__main__":
    sys.exit(main(STUDY))
