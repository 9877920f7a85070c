"""``python -m studies.plate_with_hole``."""

from studies.engine.study import run_study
from studies.plate_with_hole import STUDY

if __name__ == "__main__":
    run_study(STUDY)
