"""``python -m studies.known_answers``."""

from __future__ import annotations

import sys

from studies.harness.front import main
from studies.known_answers.study import STUDY

if __name__ == "__main__":
    sys.exit(main(STUDY))
