"""What README quotes of the twisting column, printed at the end of the study.

``python -m studies.twisting_column.summary [folder]`` prints it from a finished run.
"""

from __future__ import annotations

import sys
from pathlib import Path

from studies.engine.results import Tables, read_results
from studies.measures.tables import select
from studies.twisting_column import outside
from studies.twisting_column.claims import claims
from studies.twisting_column.methods import DEFAULT, FEM, H1, H6, PLAIN, usual
from studies.twisting_column.outside import has_limit, twist_error, twist_sequence
from studies.twisting_column.runs import lattice


def quoted(tables: Tables) -> str:
    """Every claim as judged, the sequences, and every run at the usual step."""
    lines = [f"{one.what}{', ' * bool(one.where)}{one.where}: {one.verdict}. {one.shown}"
             for one in claims(tables)]  # fmt: skip
    runs, names = usual(tables["table"]), [method.name for method in (H1, H6, DEFAULT, PLAIN, FEM)]
    lines += ["", f"Twist at 0.1 s against {outside.NAME} ({outside.twist().value:g} rad):"]
    lines += [f"{name}: {twist_sequence(runs, name).text()}" for name in names
              if has_limit(runs, name)]  # fmt: skip
    lines += ["", "Largest error of the twist at 20 .. 100 ms, energy kept, steps:"]
    for name in names:
        for _, run in select(runs, method=name).sort_values("cells").iterrows():
            if run["survived"]:
                lines.append(
                    f"{name}, {lattice(int(run['cells']))}: {100 * twist_error(run):.2f} %, "
                    f"{100 * run['energy_kept']:.1f} %, {run['steps']} steps"
                    + (", folded" if run["folded"] else "")
                )
    return "\n".join(lines)


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path("reports", "twisting_column")
    print(quoted(read_results("twisting_column", folder).tables))
