"""From tables to figures and a PDF: plots, orders, indicators, documents."""
