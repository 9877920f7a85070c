"""``python -m studies.comparison``."""

from studies.comparison import STUDY
from studies.engine.study import run_study

if __name__ == "__main__":
    run_study(STUDY)
