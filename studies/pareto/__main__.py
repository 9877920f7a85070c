from studies.engine.study import run_study
from studies.pareto import STUDY

run_study(STUDY)
