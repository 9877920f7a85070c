"""The engine of all studies: cases in workers, resuming, tables, claims, report, provenance."""
