"""``python -m studies.twisting_column``."""

from studies.engine.study import run_study
from studies.twisting_column import STUDY

if __name__ == "__main__":
    run_study(STUDY)
