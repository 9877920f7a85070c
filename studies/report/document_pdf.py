"""A document becomes a PDF: typeset by typst where it is installed, else by matplotlib."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Literal

from studies.report import document_pages
from studies.report.document import Document


def write_pdf(
    document: Document, path: Path, *, engine: Literal["auto", "typst", "pages"] = "auto"
) -> None:
    """Make the PDF; ``auto`` takes typst where it is installed."""
    if engine == "auto":
        engine = "typst" if importlib.util.find_spec("typst") else "pages"
    path.parent.mkdir(parents=True, exist_ok=True)
    if engine == "typst":
        # Imported here because the package is an extra.
        from studies.report import document_typst

        document_typst.render(document, path)
    else:
        document_pages.render(document, path)
